//! What is drawn on top of the picture.

mod boxes;
mod graph;
mod legend;
mod sheet;
mod walk;

pub(crate) use self::{
    boxes::draw as boxes, graph::draw as graph, legend::draw as legend,
    legend::height as legend_height, sheet::draw as sheet, sheet::pages, walk::draw as walk,
};

/// `text` in lines of at most `most` letters, cut at blanks where there are any.
pub(crate) fn wrapped(text: &str, most: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let mut rest: Vec<char> = word.chars().collect();
        while !rest.is_empty() {
            let line = lines.last_mut().expect("there is always one");
            let used = line.chars().count();
            let blank = usize::from(used > 0);
            if used + blank + rest.len() <= most || used == 0 {
                let taken = rest.len().min(most.max(1));
                line.extend([' '].iter().take(blank).copied().chain(rest.drain(..taken)));
            } else {
                lines.push(String::new());
            }
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::wrapped;

    #[test]
    fn lines_are_cut_at_blanks_and_long_words_anywhere() {
        assert_eq!(wrapped("a broken file", 8), ["a broken", "file"]);
        assert_eq!(
            wrapped("models/beetle.obj", 7),
            ["models/", "beetle.", "obj"]
        );
        assert_eq!(wrapped("", 7), [""]);
    }
}
