//! Errors as C has them: a code from the call, and a sentence for this thread.

use boxwood::{BuildError, FileCause, FileError};
use boxwood_host::FloatModes;
use std::any::Any;
use std::cell::RefCell;
use std::ffi::{CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Why a call failed. `bw_last_error_message` says it in a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C)]
pub enum BwError {
    /// It did not.
    None = 0,
    /// A pointer is NULL that must not be.
    NullPointer = 1,
    /// A pointer is not a multiple of what its values need (4 bytes).
    Misaligned = 2,
    /// A stride is smaller than what it steps over, or not a multiple of 4.
    BadStride = 3,
    /// More than 2^31 - 1 triangles in a scene, an array larger than memory can be, or a structure beyond 32-bit references.
    TooLarge = 4,
    /// A triangle names a vertex that does not exist.
    IndexOutOfRange = 5,
    /// The scene was never committed.
    NotCommitted = 6,
    /// The scene has no geometry or instance of this number.
    NoSuchId = 7,
    /// A scene holds triangles or instances, not both.
    Mixed = 8,
    /// Instances stand in each other more than 8 deep, or multiply to 2^32 - 1 or more.
    Nesting = 9,
    /// A matrix has a number that is not finite.
    NotFinite = 10,
    /// An argument is none of the values that it may have.
    InvalidArgument = 11,
    /// The question is not there for this kind of scene.
    Unsupported = 12,
    /// The system did not grant the memory.
    OutOfMemory = 13,
    /// The system did not grant the threads.
    NoThreads = 14,
    /// A mistake in Boxwood; please report it. The scene is as it was before the call.
    Internal = 15,
    /// The system did not let a file be read or written.
    File = 16,
    /// A file is no scene, one of another version, or damaged.
    BadFile = 17,
}

/// A failed call: what its thread is told.
#[derive(Debug)]
pub(crate) struct Failure {
    pub(crate) code: BwError,
    pub(crate) message: String,
}

impl Failure {
    #[cold]
    pub(crate) fn new(code: BwError, message: impl Into<String>) -> Self {
        let message = message.into();
        Self { code, message }
    }

    fn of_panic(panic: &(dyn Any + Send)) -> Self {
        let text = panic
            .downcast_ref::<&str>()
            .copied()
            .or_else(|| panic.downcast_ref::<String>().map(String::as_str));
        let text = text.unwrap_or("no reason given");
        Self::new(BwError::Internal, format!("a mistake in Boxwood: {text}"))
    }
}

impl From<BuildError> for Failure {
    fn from(error: BuildError) -> Self {
        let code = match error {
            BuildError::IndexOutOfRange { .. } => BwError::IndexOutOfRange,
            BuildError::TooManyPrimitives { .. } | BuildError::TooLarge { .. } => BwError::TooLarge,
            BuildError::MixedPrimitives => BwError::Mixed,
            BuildError::NestedTooDeep { .. } | BuildError::TooManyPaths { .. } => BwError::Nesting,
            BuildError::NoSuchMesh { .. } => BwError::NoSuchId,
            BuildError::OutOfMemory { .. } => BwError::OutOfMemory,
            // Names, features, counts and cancelling are not the C caller's: it cannot ask for them.
            _ => BwError::Internal,
        };
        Self::new(code, error.to_string())
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        let code = match error.cause {
            FileCause::NotSaved { .. } => BwError::Unsupported,
            FileCause::System { .. } => BwError::File,
            FileCause::OutOfMemory { .. } => BwError::OutOfMemory,
            _ => BwError::BadFile,
        };
        Self::new(code, error.to_string())
    }
}

thread_local! {
    /// What this thread was told last.
    static LAST: RefCell<Option<(BwError, CString)>> = const { RefCell::new(None) };
}

/// Runs the body of a call: keeps the caller's floating-point modes out and panics in, and remembers a failure for the thread.
#[inline]
fn run<T>(body: impl FnOnce() -> Result<T, Failure>) -> Result<T, BwError> {
    let _modes = FloatModes::enter();
    match catch_unwind(AssertUnwindSafe(body)) {
        Ok(Ok(answer)) => Ok(answer),
        Ok(Err(failure)) => Err(remember(failure)),
        Err(panic) => Err(remember(Failure::of_panic(&*panic))),
    }
}

/// [`run`] for calls that answer with something else than a code.
#[inline]
pub(crate) fn call<T>(on_failure: T, body: impl FnOnce() -> Result<T, Failure>) -> T {
    run(body).unwrap_or(on_failure)
}

/// [`run`] for calls that answer with a code.
pub(crate) fn status(body: impl FnOnce() -> Result<(), Failure>) -> BwError {
    run(body).err().unwrap_or(BwError::None)
}

#[cold]
fn remember(Failure { code, message }: Failure) -> BwError {
    let message = CString::new(message.replace('\0', "?")).unwrap_or_default();
    // A thread that is ending may have dropped it already: then nobody is left to ask.
    let _ = LAST.try_with(|last| last.replace(Some((code, message))));
    code
}

/// The code of this thread's latest failed call.
pub(crate) fn last_code() -> BwError {
    let code =
        |last: &RefCell<Option<(BwError, CString)>>| last.borrow().as_ref().map(|last| last.0);
    LAST.try_with(code).ok().flatten().unwrap_or(BwError::None)
}

/// Its message, there until [`remember`] or [`forget`] is called on this thread.
pub(crate) fn last_message() -> *const c_char {
    let text = |last: &RefCell<Option<(BwError, CString)>>| {
        last.borrow().as_ref().map(|last| last.1.as_ptr())
    };
    LAST.try_with(text).ok().flatten().unwrap_or(c"".as_ptr())
}

/// As if no call had failed.
pub(crate) fn forget() {
    let _ = LAST.try_with(|last| last.take());
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CStr;

    fn message() -> String {
        let text = last_message();
        #[expect(unsafe_code, reason = "what C does with the message")]
        // SAFETY: a C string that lives until the next failed call of this thread, which is none before the copy.
        unsafe { CStr::from_ptr(text) }.to_str().unwrap().to_owned()
    }

    #[test]
    fn a_panic_becomes_a_code_with_its_reason_and_the_next_call_works() {
        assert_eq!(
            status(|| panic!("lost the {}", "thread")),
            BwError::Internal
        );
        assert_eq!(last_code(), BwError::Internal);
        assert_eq!(message(), "a mistake in Boxwood: lost the thread");
        assert_eq!(call(7, || Ok(8)), 8);
        assert_eq!(last_code(), BwError::Internal, "success forgets nothing");
        forget();
        assert_eq!((last_code(), message()), (BwError::None, String::new()));
    }

    #[test]
    fn each_thread_has_its_own_error() {
        let failed = || status(|| Err(Failure::new(BwError::Mixed, "a\0b")));
        assert_eq!(failed(), BwError::Mixed);
        assert_eq!(message(), "a?b");
        let other = std::thread::spawn(|| (last_code(), message())).join();
        assert_eq!(other.unwrap(), (BwError::None, String::new()));
    }
}
