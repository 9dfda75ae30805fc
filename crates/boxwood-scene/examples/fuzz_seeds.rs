//! Writes the first corpus of the fuzzers: `fuzz_seeds FOLDER` makes `FOLDER/obj/0` and so on.
#![forbid(unsafe_code)]

#[path = "../tests/support/seeds.rs"]
mod seeds;

use std::path::Path;
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let folder = env::args_os()
        .nth(1)
        .ok_or_else(|| io::Error::other("usage: fuzz_seeds FOLDER"))?;
    for (i, (format, bytes)) in seeds::seeds()
        .into_iter()
        .chain(seeds::sealed_seeds())
        .enumerate()
    {
        let corpus = Path::new(&folder).join(format);
        fs::create_dir_all(&corpus)?;
        fs::write(corpus.join(i.to_string()), bytes)?;
    }
    Ok(())
}
