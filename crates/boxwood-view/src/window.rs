//! The window around the viewer: everything that knows winit and softbuffer.

use std::{
    num::NonZeroU32,
    rc::Rc,
    sync::{Arc, Mutex, PoisonError},
    time::Instant,
};

use softbuffer::{Context, Surface};
use winit::{
    application::ApplicationHandler,
    dpi::PhysicalSize,
    event::{ElementState, KeyEvent, MouseButton, MouseScrollDelta, WindowEvent},
    event_loop::{ActiveEventLoop, ControlFlow, EventLoop},
    keyboard::{Key as WinitKey, NamedKey},
    window::{Fullscreen, Window, WindowId},
};

use crate::{
    App, Button, Event, Key, Matter, Options, Report, Rest, Script, State, ViewError, Wish,
    script::Runner,
};

/// Opens a window and stays until the user closes it, or the script is over. `heed` gets what is to be printed.
///
/// Gives what is to be remembered, and how the script went. Call it on the main thread; a process can do so once.
///
/// # Errors
/// If there is no screen, or the window is refused; if a script fails.
pub fn run_window(
    options: Options,
    script: Option<Script>,
    heed: &mut dyn FnMut(Wish),
) -> Result<(State, Report), ViewError> {
    let events = EventLoop::new().map_err(|error| no_window(&error.to_string()))?;
    let proxy = Mutex::new(events.create_proxy());
    let wake = Arc::new(move || {
        // After the window is gone nobody is to be woken.
        let _ = proxy
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
            .send_event(());
    });
    let mut handler = Handler {
        size: options.size,
        app: App::new(Options { wake, ..options }),
        screen: None,
        title: String::new(),
        runner: script.map(Runner::new),
        last: Instant::now(),
        frame_began: None,
        heed,
        error: None,
    };
    events
        .run_app(&mut handler)
        .map_err(|error| no_window(&error.to_string()))?;
    if let Some(error) = handler.error {
        return Err(error);
    }
    let report = handler.runner.map(Runner::report).unwrap_or_default();
    Ok((handler.app.state(), report))
}

/// There is none, because of `cause`, in which winit names a place in its own source.
fn no_window(cause: &str) -> ViewError {
    let place = cause
        .strip_prefix("os error at ")
        .and_then(|place| place.split_once(".rs:"));
    let cause = place
        .and_then(|(_, line)| line.split_once(": "))
        .map_or(cause, |(_, plain)| plain);
    ViewError::new(Matter::Window, format!("no window can be opened: {cause}"))
}

/// The window, and the way to its pixels.
struct Screen {
    window: Rc<Window>,
    surface: Surface<Rc<Window>, Rc<Window>>,
}

struct Handler<'a> {
    app: App,
    size: [u32; 2],
    screen: Option<Screen>,
    /// Of the window.
    title: String,
    runner: Option<Runner>,
    /// When the viewer last advanced.
    last: Instant,
    /// When the frame that is on the screen was begun.
    frame_began: Option<Instant>,
    heed: &'a mut dyn FnMut(Wish),
    error: Option<ViewError>,
}

impl ApplicationHandler for Handler<'_> {
    fn resumed(&mut self, events: &ActiveEventLoop) {
        if self.screen.is_some() {
            return;
        }
        match Screen::open(events, self.size) {
            Ok(screen) => self.screen = Some(screen),
            Err(error) => self.fail(events, no_window(&error)),
        }
    }

    fn user_event(&mut self, _: &ActiveEventLoop, (): ()) {}

    fn window_event(&mut self, events: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        // Keys act from now on, not since the last frame.
        self.advance();
        match event {
            WindowEvent::CloseRequested => events.exit(),
            WindowEvent::RedrawRequested => self.redraw(events),
            event => {
                if let Some(event) = translated(&event) {
                    self.app.handle(event);
                }
            }
        }
        self.fulfil(events);
    }

    fn about_to_wait(&mut self, events: &ActiveEventLoop) {
        self.advance();
        self.fulfil(events);
        let Some(screen) = &self.screen else { return };
        let title = self.app.title();
        // X11 tells the window of each new title, the same too, which would end the rest before it began.
        if title != self.title {
            screen.window.set_title(&title);
            self.title = title;
        }
        match self.app.rest() {
            Rest::AtMost(time) if self.runner.is_none() => {
                events.set_control_flow(ControlFlow::WaitUntil(Instant::now() + time));
            }
            _ => {
                events.set_control_flow(ControlFlow::Poll);
                screen.window.request_redraw();
            }
        }
    }
}

impl Handler<'_> {
    fn advance(&mut self) {
        let now = Instant::now();
        self.app.advance(now - self.last);
        self.last = now;
    }

    fn fail(&mut self, events: &ActiveEventLoop, error: ViewError) {
        self.error = Some(error);
        events.exit();
    }

    fn fulfil(&mut self, events: &ActiveEventLoop) {
        for wish in self.app.wishes() {
            match wish {
                Wish::Quit => events.exit(),
                Wish::ToggleFullScreen => {
                    if let Some(Screen { window, .. }) = &self.screen {
                        let is_full = window.fullscreen().is_some();
                        window.set_fullscreen((!is_full).then_some(Fullscreen::Borderless(None)));
                    }
                }
                said if self.runner.is_some() && Runner::will_say(&self.app, &said) => {}
                said => (self.heed)(said),
            }
        }
    }

    /// A frame, and what a script does before and after it.
    fn redraw(&mut self, events: &ActiveEventLoop) {
        let now = Instant::now();
        let since = self.frame_began.replace(now);
        if let Some(runner) = &mut self.runner {
            if let Some(since) = since {
                runner.after(&self.app, now - since);
            }
            match runner.before(&mut self.app) {
                Ok(Some(())) => {}
                Ok(None) => return events.exit(),
                Err(error) => return self.fail(events, error),
            }
        }
        let Some(screen) = &mut self.screen else {
            return;
        };
        if let Err(error) = screen.show(&mut self.app) {
            self.fail(events, no_window(&error));
        }
    }
}

impl Screen {
    fn open(events: &ActiveEventLoop, [width, height]: [u32; 2]) -> Result<Self, String> {
        let attributes = Window::default_attributes()
            .with_title("boxwood")
            .with_inner_size(PhysicalSize::new(width, height));
        let window = events
            .create_window(attributes)
            .map_err(|error| error.to_string())?;
        let window = Rc::new(window);
        let context = Context::new(Rc::clone(&window)).map_err(|error| error.to_string())?;
        let surface =
            Surface::new(&context, Rc::clone(&window)).map_err(|error| error.to_string())?;
        Ok(Self { window, surface })
    }

    /// Draws a frame into the window.
    fn show(&mut self, app: &mut App) -> Result<(), String> {
        let PhysicalSize { width, height } = self.window.inner_size();
        let (Some(w), Some(h)) = (NonZeroU32::new(width), NonZeroU32::new(height)) else {
            return Ok(());
        };
        app.handle(Event::Resize([width, height]));
        let frame = app.draw();
        let start = Instant::now();
        self.surface
            .resize(w, h)
            .map_err(|error| error.to_string())?;
        let mut buffer = self
            .surface
            .buffer_mut()
            .map_err(|error| error.to_string())?;
        for (pixel, &[r, g, b]) in buffer.iter_mut().zip(&frame.rgb) {
            *pixel = u32::from_be_bytes([0, r, g, b]);
        }
        buffer.present().map_err(|error| error.to_string())?;
        app.presented(start.elapsed());
        Ok(())
    }
}

/// The viewer's word for an event, if it has one.
fn translated(event: &WindowEvent) -> Option<Event> {
    Some(match event {
        WindowEvent::KeyboardInput { event, .. } => return key_event(event),
        WindowEvent::ModifiersChanged(modifiers) => Event::Shift(modifiers.state().shift_key()),
        WindowEvent::Focused(false) => Event::FocusLost,
        WindowEvent::Resized(size) => Event::Resize([size.width, size.height]),
        WindowEvent::DroppedFile(path) => Event::Drop(path.clone()),
        WindowEvent::CursorMoved { position, .. } => {
            Event::Pointer([position.x as f32, position.y as f32])
        }
        WindowEvent::MouseWheel { delta, .. } => Event::Wheel(match delta {
            MouseScrollDelta::LineDelta(_, lines) => *lines,
            MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
        }),
        WindowEvent::MouseInput { state, button, .. } => match (state, button) {
            (ElementState::Released, _) => Event::ButtonsUp,
            (ElementState::Pressed, MouseButton::Left) => Event::ButtonDown(Button::Left),
            (ElementState::Pressed, _) => Event::ButtonDown(Button::Other),
        },
        _ => return None,
    })
}

fn key_event(event: &KeyEvent) -> Option<Event> {
    let key = key_of(&event.logical_key)?;
    match event.state {
        ElementState::Pressed if event.repeat && !key.repeats() => None,
        ElementState::Pressed => Some(Event::Press(key)),
        ElementState::Released => Some(Event::Release(key)),
    }
}

fn key_of(key: &WinitKey) -> Option<Key> {
    Some(match key {
        WinitKey::Character(text) => Key::Char(match text.chars().next()? {
            // The same keys with shift.
            '<' => ',',
            '>' => '.',
            letter => letter.to_ascii_lowercase(),
        }),
        WinitKey::Named(named) => match named {
            NamedKey::Escape => Key::Escape,
            NamedKey::ArrowLeft => Key::Left,
            NamedKey::ArrowRight => Key::Right,
            NamedKey::ArrowUp => Key::Up,
            NamedKey::ArrowDown => Key::Down,
            _ => Key::F(1 + FUNCTION_KEYS.iter().position(|key| key == named)? as u8),
        },
        _ => return None,
    })
}

const FUNCTION_KEYS: [NamedKey; 12] = [
    NamedKey::F1,
    NamedKey::F2,
    NamedKey::F3,
    NamedKey::F4,
    NamedKey::F5,
    NamedKey::F6,
    NamedKey::F7,
    NamedKey::F8,
    NamedKey::F9,
    NamedKey::F10,
    NamedKey::F11,
    NamedKey::F12,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn that_there_is_no_window_is_said_without_places_in_foreign_source() {
        let plain = "neither WAYLAND_DISPLAY nor DISPLAY is set";
        let placed = format!("os error at /somewhere/winit-0.30.12/src/x11/mod.rs:764: {plain}");
        for cause in [plain, placed.as_str()] {
            let said = no_window(cause).to_string();
            assert_eq!(said, format!("no window can be opened: {plain}"));
        }
    }
}
