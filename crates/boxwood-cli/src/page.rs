//! The page that teaches (`web/`), at hand: from the program itself, or from a folder that `cargo xtask web` has built.

mod model;
mod serve;

use std::{
    env, fs,
    path::{Path, PathBuf},
};

use percent_encoding::{AsciiSet, NON_ALPHANUMERIC, utf8_percent_encode};

use crate::output::Trouble;

pub(crate) use {
    model::{Offer, Source},
    serve::Server,
};

/// What links may hold as it is.
const IN_LINKS: &AsciiSet = &NON_ALPHANUMERIC
    .remove(b'-')
    .remove(b'_')
    .remove(b'.')
    .remove(b':');

/// Where the files of the page are.
#[derive(Clone, Debug)]
pub(crate) enum Page {
    /// In the program, which was built with `--features page`.
    #[cfg(feature = "page")]
    Inside,
    /// In a folder.
    Folder(PathBuf),
}

impl Page {
    /// The page in `folder`; without one that in the program, else one that lies beside it, as in `target`.
    pub(crate) fn find(folder: Option<&Path>) -> anyhow::Result<Self> {
        if let Some(folder) = folder {
            if !is_page(folder) {
                let cause = format!("{}: no index.html in it", folder.display());
                return Err(Trouble::input(cause, BUILD_IT).into());
            }
            return Ok(Self::Folder(folder.to_owned()));
        }
        #[cfg(feature = "page")]
        let inside = Some(Self::Inside);
        #[cfg(not(feature = "page"))]
        let inside = None;
        inside
            .or_else(|| beside_the_program().map(Self::Folder))
            .ok_or_else(|| {
                Trouble::usage("this boxwood was built without the page", BUILD_IT).into()
            })
    }

    /// The bytes of the file that the browser calls `name`, which is plain: see [`serve`].
    fn read(&self, name: &str) -> Option<Vec<u8>> {
        match self {
            #[cfg(feature = "page")]
            Self::Inside => FILES.get_file(name).map(|file| file.contents().to_vec()),
            Self::Folder(folder) => fs::read(folder.join(name)).ok(),
        }
    }
}

const BUILD_IT: &str = "build it with `cargo xtask web` and name its folder: --page target/web; or unpack boxwood-web.zip and name that";

/// As `cargo xtask web` left them before the program was compiled.
#[cfg(feature = "page")]
static FILES: include_dir::Dir<'static> = include_dir::include_dir!("$BOXWOOD_PAGE");

fn beside_the_program() -> Option<PathBuf> {
    let program = env::current_exe().ok()?;
    let folders = program.ancestors().skip(1).take(2);
    folders
        .map(|folder| folder.join("web"))
        .find(|web| is_page(web))
}

fn is_page(folder: &Path) -> bool {
    folder.join("index.html").is_file()
}

/// What follows the address to open a scene: a file that the server has, or one that is built in.
fn query(scene: &str) -> String {
    const BUILT_IN: &str = "builtin:";
    let name = Path::new(scene).file_name().and_then(|name| name.to_str());
    let name = match name {
        _ if scene.starts_with(BUILT_IN) => scene.to_owned(),
        // A file in a folder may be called so, and the page would take it for what is built in.
        Some(name) if name.starts_with(BUILT_IN) => format!("./{name}"),
        name => name.unwrap_or(scene).to_owned(),
    };
    format!("?open={}", utf8_percent_encode(&name, IN_LINKS))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_link_names_the_file_without_its_folder() {
        assert_eq!(query("models/a b&c.obj"), "?open=a%20b%26c.obj");
        assert_eq!(
            query("builtin:terrain?n=9"),
            "?open=builtin:terrain%3Fn%3D9"
        );
    }

    #[test]
    fn a_file_that_is_called_as_a_built_in_scene_is_still_a_file() {
        for file in ["./builtin:cornell", "models/builtin:cornell"] {
            assert_eq!(query(file), "?open=.%2Fbuiltin:cornell");
        }
    }

    #[test]
    fn a_folder_without_a_page_is_refused_with_the_remedy() {
        let error = Page::find(Some(Path::new("no/such"))).unwrap_err();
        assert!(
            error.to_string().contains("no/such: no index.html"),
            "{error}"
        );
    }
}
