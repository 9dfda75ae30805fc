//! The warnings of the loader, as many as people read.

/// How the loader ends what it says of a texture that cannot be had.
const NO_TEXTURE: &str = "shown without this texture";
/// Of such textures so many are named.
const NAMED: usize = 3;

/// All of `warnings`, but of missing textures the first few and how many more there are.
pub(crate) fn shortened(warnings: &[String]) -> Vec<String> {
    let mut textures = 0;
    let is_named = |warning: &&String| {
        textures += usize::from(warning.ends_with(NO_TEXTURE));
        textures <= NAMED || !warning.ends_with(NO_TEXTURE)
    };
    let mut shown: Vec<String> = warnings.iter().filter(is_named).cloned().collect();
    match textures.saturating_sub(NAMED) {
        0 => {}
        1 => shown.push("... and 1 more texture is missing".to_owned()),
        more => shown.push(format!("... and {more} more textures are missing")),
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_many_textures_three_are_named_and_the_rest_counted() {
        let texture = |i: usize| format!("{i}.png: cannot be read; {NO_TEXTURE}");
        let warnings = |textures: usize| {
            let mut all: Vec<String> = (0..textures).map(texture).collect();
            all.push("something else".to_owned());
            all
        };
        assert_eq!(shortened(&warnings(3)), warnings(3));
        let shown = shortened(&warnings(12));
        assert_eq!(shown[..3], warnings(3)[..3]);
        assert_eq!(
            shown[3..],
            ["something else", "... and 9 more textures are missing"]
        );
    }
}
