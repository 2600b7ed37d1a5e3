//! Templates: text with places named `{{name}}`.

/// The template with its parts filled in. What a part holds is not searched for further places.
///
/// # Errors
/// The name of a place that there is no part for.
pub fn fill(template: &str, parts: &[(&str, &str)]) -> Result<String, String> {
    let (mut out, mut rest) = (String::new(), template);
    while let Some((before, after)) = rest.split_once("{{") {
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        let part = parts.iter().find(|p| p.0 == name).ok_or(name)?;
        out += before;
        out += part.1;
        rest = after;
    }
    Ok(out + rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_filled_once_and_must_have_a_part() {
        let parts = [("a", "{{b}}"), ("b", "1")];
        assert_eq!(fill("x{{a}}y{{b}}{{a}}", &parts).as_deref(), Ok("x{{b}}y1{{b}}"));
        assert_eq!(fill("no place }}", &parts).as_deref(), Ok("no place }}"));
        assert_eq!(fill("{{c}}", &parts), Err("c".into()));
        assert_eq!(fill("{{a", &parts).as_deref(), Ok("{{b}}"));
    }
}
