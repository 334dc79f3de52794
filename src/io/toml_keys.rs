//! Flat TOML tables with errors that name the line and what would be right.

use crate::Error;
use toml::de::{DeTable, DeValue};

/// The keys of a TOML file, all of them known.
pub struct Keys<'t> {
    table: DeTable<'t>,
    text: &'t str,
}

impl<'t> Keys<'t> {
    /// Reads a table whose keys are all in `known`.
    pub fn parse(text: &'t str, known: &[&str]) -> Result<Self, Error> {
        let table = DeTable::parse(text).map_err(|error| {
            let start = error.span().map_or(0, |span| span.start);
            Error::new(
                format!("It is not TOML: {}.", error.message().trim_end_matches('.').replace('\n', ", ")),
                "Write one `key = value` a line, text in double quotes.",
            )
            .within(line_of(text, start))
        })?;
        Self::of(table.into_inner(), text, known)
    }

    /// A table of a text, whose keys are all in `known`.
    fn of(table: DeTable<'t>, text: &'t str, known: &[&str]) -> Result<Self, Error> {
        let keys = Self { table, text };
        // In the order of the file, so that the first slip is the one that is told.
        let mut unknown: Vec<_> = keys.table.keys().filter(|key| !known.contains(&key.get_ref().as_ref())).collect();
        unknown.sort_by_key(|key| key.span().start);
        match unknown.first() {
            None => Ok(keys),
            Some(key) => {
                let name = key.get_ref().as_ref();
                let problem = format!("The key `{}` is not known.", shortened(name));
                Err(Error::new(problem, remedy_for_key(name, known)).within(line_of(text, key.span().start)))
            }
        }
    }

    /// The tables of a key that is written `[[key]]`, each with the line on which it starts; keys of each are in
    /// `known`. None where the key is missing.
    pub fn tables(&self, key: &str, known: &[&str]) -> Result<Vec<(Keys<'t>, String)>, Error> {
        let Some(value) = self.table.get(key) else { return Ok(Vec::new()) };
        let wrong = || self.wrong(key, "is not a list of tables", &format!("Start each with a line `[[{key}]]`."));
        let array = value.get_ref().as_array().ok_or_else(wrong)?;
        let table = |value: &toml::Spanned<DeValue<'t>>| {
            let table = value.get_ref().as_table().ok_or_else(wrong)?.clone();
            Ok((Keys::of(table, self.text, known)?, line_of(self.text, value.span().start)))
        };
        array.iter().map(table).collect()
    }

    /// The lists of texts of a key, one for each entry; an entry is a text or a list of texts.
    pub fn lists(&self, key: &str) -> Result<Option<Vec<Vec<&str>>>, Error> {
        let Some(value) = self.table.get(key) else { return Ok(None) };
        let wrong = || {
            self.wrong(key, "is not a list of texts", "Write [\"one\", \"other\"]; an entry may itself be such a list.")
        };
        let text = |value: &'_ toml::Spanned<DeValue<'t>>| value.get_ref().as_str().is_some();
        let entry = |value| -> Result<Vec<&str>, Error> {
            let value: &toml::Spanned<DeValue<'t>> = value;
            if let Some(one) = value.get_ref().as_str() {
                return Ok(vec![one]);
            }
            let inner = value.get_ref().as_array().filter(|inner| inner.iter().all(text)).ok_or_else(wrong)?;
            Ok(inner.iter().filter_map(|v| v.get_ref().as_str()).collect())
        };
        value.get_ref().as_array().ok_or_else(wrong)?.iter().map(entry).collect::<Result<_, _>>().map(Some)
    }

    /// Yes or no, if the key is there.
    pub fn truth(&self, key: &str) -> Result<Option<bool>, Error> {
        let Some(value) = self.table.get(key) else { return Ok(None) };
        match value.get_ref().as_bool() {
            Some(truth) => Ok(Some(truth)),
            None => Err(self.wrong(key, "is neither true nor false", "Write true or false, without quotes.")),
        }
    }

    /// The number of a key, finite, if the key is there. Whole numbers are numbers too.
    pub fn number(&self, key: &str) -> Result<Option<f64>, Error> {
        let Some(value) = self.table.get(key) else { return Ok(None) };
        let number = match value.get_ref() {
            DeValue::Float(float) => float.as_str().replace('_', "").parse().ok(),
            DeValue::Integer(_) => integer(value.get_ref()).map(|i| i as f64),
            _ => None,
        };
        match number.filter(|n: &f64| n.is_finite()) {
            Some(number) => Ok(Some(number)),
            None => Err(self.wrong(key, "is not a number", "Give a finite number, without quotes.")),
        }
    }

    /// The count of a key, at least one and at most `most`, if the key is there.
    pub fn count(&self, key: &str, most: usize) -> Result<Option<usize>, Error> {
        let Some(value) = self.table.get(key) else { return Ok(None) };
        match integer(value.get_ref()).and_then(|i| usize::try_from(i).ok()).filter(|i| (1..=most).contains(i)) {
            Some(count) => Ok(Some(count)),
            None => Err(self.wrong(key, "is not a count", &format!("Give a whole number from 1 to {most}."))),
        }
    }

    /// The text of a key, if the key is there.
    pub fn text(&self, key: &str) -> Result<Option<&str>, Error> {
        let Some(value) = self.table.get(key) else { return Ok(None) };
        match value.get_ref().as_str() {
            Some(text) => Ok(Some(text)),
            None => Err(self.wrong(key, "is not text", "Put the value in double quotes.")),
        }
    }

    /// The line on which the value of a key stands, as a place for an error.
    pub fn place(&self, key: &str) -> String {
        self.table.get(key).map_or(String::new(), |value| line_of(self.text, value.span().start))
    }

    fn wrong(&self, key: &str, what: &str, remedy: &str) -> Error {
        Error::new(format!("`{key}` {what}."), remedy).within(self.place(key))
    }
}

fn integer(value: &DeValue) -> Option<i64> {
    let integer = value.as_integer()?;
    i64::from_str_radix(&integer.as_str().replace('_', ""), integer.radix()).ok()
}

pub fn line_of(text: &str, at: usize) -> String {
    let before = text.as_bytes().iter().take(at);
    format!("line {}", 1 + before.filter(|&&b| b == b'\n').count())
}

/// Names the known word that is most like `name`, or all of them.
pub fn remedy_for_key(name: &str, known: &[&str]) -> String {
    // Below this likeness, from 0 to 1, a suggestion would puzzle.
    const ALIKE: f64 = 0.8;
    let likeness = |word: &&str| strsim::jaro_winkler(&shortened(name), word);
    let nearest = known.iter().copied().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    match nearest.filter(|word| likeness(word) >= ALIKE) {
        Some(word) => format!("Did you mean `{word}`?"),
        None => format!("Known are {}.", known.join(", ")),
    }
}

/// A name that fits into a message.
fn shortened(name: &str) -> String {
    const MOST_CHARACTERS: usize = 60;
    name.chars().take(MOST_CHARACTERS).collect()
}

/// Text as a TOML string, quotes and all.
pub fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_key_names_its_line_and_the_nearest() {
        let error = Keys::parse("# none\nthickness = 1\nfricton = 0.3", &["thickness", "friction"]).err().unwrap();
        assert_eq!(error.to_string(), "line 3: The key `fricton` is not known.");
        assert_eq!(error.remedy(), "Did you mean `friction`?");
        let error = Keys::parse("color = 3", &["thickness", "friction"]).err().unwrap();
        assert_eq!(error.remedy(), "Known are thickness, friction.");
    }

    #[test]
    fn values_of_the_wrong_kind_name_their_line() {
        let known = ["a", "b", "c", "d", "e"];
        let keys = Keys::parse("a = 0x1_0\nb = \"1\"\nc = 1_0.5e1\nd = nan\ne = -1", &known).unwrap();
        assert_eq!((keys.number("a"), keys.count("a", 99)), (Ok(Some(16.0)), Ok(Some(16))));
        assert_eq!(keys.number("b").unwrap_err().place(), "line 2");
        assert_eq!(keys.number("c"), Ok(Some(105.0)));
        assert!(keys.number("d").is_err() && keys.count("e", 99).is_err() && keys.text("a").is_err());
        assert_eq!(keys.number("f"), Ok(None));
    }

    #[test]
    fn broken_toml_names_the_line() {
        for text in ["a = 1\nb =", "a = 1\na = 2", "a = 1\n[[[", "a = 1\nb = 99999999999999999999999999 1"] {
            assert_eq!(Keys::parse(text, &["a", "b"]).err().unwrap().place(), "line 2", "{text}");
        }
        assert!(Keys::parse(&format!("a = {}", "[".repeat(100_000)), &["a"]).is_err());
    }
}
