//! The file being read, its limits, and the words for refusing it.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

use crate::{Error, Limits, Warning};

/// What every step needs to refuse something: which file it is about and what is allowed.
#[derive(Clone, Copy)]
pub(crate) struct Asset<'a> {
    pub(crate) path: &'a Path,
    pub(crate) limits: &'a Limits,
}

impl Asset<'_> {
    /// The file is wrong at `place`.
    pub(crate) fn format(&self, place: impl Into<String>, problem: impl Into<String>) -> Error {
        Error::Format { path: self.path.to_owned(), place: place.into(), problem: problem.into() }
    }

    /// The file asks for something we do not do.
    pub(crate) fn unsupported(
        &self,
        place: impl Into<String>,
        feature: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Error {
        Error::Unsupported {
            path: self.path.to_owned(),
            place: place.into(),
            feature: feature.into(),
            remedy: remedy.into(),
        }
    }

    /// Refuses `found` things where only `allowed` are allowed.
    pub(crate) fn check_limit(
        &self,
        place: impl Into<String>,
        what: &'static str,
        found: u64,
        allowed: u64,
    ) -> Result<(), Error> {
        if found <= allowed {
            return Ok(());
        }
        Err(Error::Limit { path: self.path.to_owned(), place: place.into(), what, found, allowed })
    }
}

/// Collects warnings in the order in which they come up; one entry per code and place.
#[derive(Default)]
pub(crate) struct Warnings {
    list: Vec<Warning>,
    /// Where each code and place stands in the list.
    known: BTreeMap<(&'static str, String), usize>,
}

impl Warnings {
    /// Adds `count` to the warning with this code and place; the first message stays.
    pub(crate) fn add(&mut self, code: &'static str, place: &str, count: u64, message: impl Into<String>) {
        if count == 0 {
            return;
        }
        match self.known.entry((code, place.to_owned())) {
            Entry::Occupied(known) => self.list[*known.get()].count += count,
            Entry::Vacant(fresh) => {
                fresh.insert(self.list.len());
                self.list.push(Warning { code, place: place.to_owned(), count, message: message.into() });
            }
        }
    }

    pub(crate) fn into_list(self) -> Vec<Warning> {
        self.list
    }
}
