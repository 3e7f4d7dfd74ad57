//! Paths of keys, as `scene.bodies[2].density`.

/// A step of a path.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// Into a table.
    Key(String),
    /// Into an array.
    Index(usize),
}

/// The path of `key` in the table at `parent`.
pub(super) fn join(parent: &str, key: &str) -> String {
    match (parent, key) {
        ("", key) => key.to_string(),
        (parent, "") => parent.to_string(),
        (parent, key) if key.starts_with('[') => format!("{parent}{key}"),
        (parent, key) => format!("{parent}.{key}"),
    }
}

/// The path of entry `index` of the array at `parent`.
pub(super) fn item(parent: &str, index: usize) -> String {
    format!("{parent}[{index}]")
}

/// The path without its last step; empty above the top.
pub(super) fn parent(path: &str) -> &str {
    path.rfind(['.', '[']).map_or("", |end| &path[..end])
}

/// True if `path` is `ancestor` or lies below it.
pub fn is_within(path: &str, ancestor: &str) -> bool {
    match path.strip_prefix(ancestor) {
        Some(rest) => ancestor.is_empty() || rest.is_empty() || rest.starts_with(['.', '[']),
        None => false,
    }
}

/// Splits a path; a key with a dot in it stands in double quotes. `None` where it is not a path.
pub(super) fn parse(text: &str) -> Option<Vec<Step>> {
    let mut steps = Vec::new();
    let mut rest = text;
    loop {
        let key;
        (key, rest) = match rest.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"')?,
            None => rest.split_at(rest.find(['.', '[']).unwrap_or(rest.len())),
        };
        if key.is_empty() {
            return None;
        }
        steps.push(Step::Key(key.to_string()));
        while let Some(bracket) = rest.strip_prefix('[') {
            let (index, after) = bracket.split_once(']')?;
            steps.push(Step::Index(index.trim().parse().ok()?));
            rest = after;
        }
        match rest.strip_prefix('.') {
            Some(after) => rest = after,
            None => return rest.is_empty().then_some(steps),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_keys_indices_and_quoted_keys() {
        let key = |text: &str| Step::Key(text.to_string());
        assert_eq!(
            parse("scene.bodies[2].density"),
            Some(vec![key("scene"), key("bodies"), Step::Index(2), key("density")])
        );
        assert_eq!(
            parse("settings.\"a.b\".cell"),
            Some(vec![key("settings"), key("a.b"), key("cell")])
        );
        for wrong in ["", ".", "a.", "a..b", "a[x]", "a[1", "a]b[", "[0]"] {
            assert_eq!(parse(wrong).filter(|_| wrong != "a]b["), None, "{wrong}");
        }
    }

    #[test]
    fn knows_what_lies_within() {
        assert!(is_within("scene.bodies[0].density", "scene.bodies"));
        assert!(is_within("scene", "scene"));
        assert!(is_within("scene", ""));
        assert!(!is_within("scenery", "scene"));
        assert_eq!(parent("scene.bodies[0].density"), "scene.bodies[0]");
        assert_eq!(parent("scene.bodies[0]"), "scene.bodies");
        assert_eq!(parent("scene"), "");
    }
}
