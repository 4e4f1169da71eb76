//! What was proved, how much that says, and what was refuted.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use std::time::Duration;

use super::case::Case;
use super::execute::NEAR_M;
use super::make::mesh::{Form, Format};
use super::make::path::Step;
use super::make::scene::Text;
use super::robot::Kind;
use super::theme::Theme;
use super::verdict::Verdict;

/// Refuted answers of a theme that are told in full.
const MOST_TOLD: usize = 3;

/// What was asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Asked {
    /// `check`, in this process.
    Check,
    /// `shorten`, in this process.
    Shorten,
    /// `taut check`.
    CommandCheck,
    /// `taut shorten`, then `taut export`.
    Export,
}

/// An answer that does not hold.
#[derive(Clone, Debug)]
pub struct Refuted {
    pub case: u64,
    pub theme: Theme,
    pub asked: Asked,
    pub steps: BTreeSet<Step>,
    pub what: String,
    /// Where its files are kept.
    pub folder: String,
    /// Proved segments of its theme until then, in its thread.
    pub after: u64,
}

/// Counts of proved segments, and of answers that proved nothing.
#[derive(Clone, Debug, Default)]
pub struct Summary {
    pub cases: u64,
    /// By what was asked; without and with meshes.
    proved: BTreeMap<Asked, [u64; 2]>,
    near: u64,
    by_kind: BTreeMap<Kind, u64>,
    by_format: BTreeMap<Format, u64>,
    by_form: BTreeMap<Form, u64>,
    by_step: BTreeMap<Step, u64>,
    by_text: BTreeMap<Text, u64>,
    by_theme: BTreeMap<Theme, u64>,
    /// Cases with proved segments that have what a scene may have.
    attached: u64,
    refused: BTreeMap<String, u64>,
    unread: BTreeMap<(Theme, String), u64>,
    pub refuted: Vec<Refuted>,
}

impl Summary {
    pub fn proved(
        &mut self,
        case: &Case,
        asked: Asked,
        steps: &BTreeSet<Step>,
        rows: &[Vec<f64>],
        verdict: &Verdict,
    ) {
        let segments = verdict.executed.nearest_m.len() as u64;
        self.proved.entry(asked).or_default()[usize::from(!case.meshes.is_empty())] += segments;
        self.near += verdict
            .executed
            .nearest_m
            .iter()
            .filter(|nearest| **nearest < NEAR_M)
            .count() as u64;
        for ends in rows.windows(2) {
            let kinds: BTreeSet<Kind> = case.kinds_moved(&ends[0], &ends[1]).collect();
            kinds
                .into_iter()
                .for_each(|kind| *self.by_kind.entry(kind).or_default() += 1);
        }
        let formats: BTreeSet<_> = case.meshes.iter().map(|mesh| mesh.0).collect();
        formats
            .into_iter()
            .for_each(|format| *self.by_format.entry(format).or_default() += segments);
        let forms: BTreeSet<_> = case.meshes.iter().map(|mesh| mesh.1).collect();
        forms
            .into_iter()
            .for_each(|form| *self.by_form.entry(form).or_default() += segments);
        steps
            .iter()
            .for_each(|step| *self.by_step.entry(*step).or_default() += segments);
        *self.by_text.entry(case.scene.text).or_default() += segments;
        *self.by_theme.entry(case.theme).or_default() += segments;
        self.attached += segments * u64::from(!case.scene.attached.is_empty());
    }

    pub fn refused(&mut self, reason: String) {
        *self.refused.entry(reason).or_default() += 1;
    }

    pub fn unread(&mut self, theme: Theme, reason: &str) {
        let last = reason.lines().last().unwrap_or_default();
        // Where a file is tells nothing.
        let words: Vec<&str> = last
            .split(' ')
            .filter(|word| !word.contains(super::SCRATCH))
            .collect();
        let plain = words.join(" ");
        let words = plain
            .chars()
            .map(|c| if c.is_ascii_digit() { '#' } else { c })
            .take(120)
            .collect();
        *self.unread.entry((theme, words)).or_default() += 1;
    }

    /// Proved segments of a theme so far.
    pub fn of_theme(&self, theme: Theme) -> u64 {
        self.by_theme
            .get(&theme)
            .copied()
            .unwrap_or_default()
    }

    pub fn add(&mut self, other: Self) {
        fn join<K: Ord>(into: &mut BTreeMap<K, u64>, from: BTreeMap<K, u64>) {
            from.into_iter()
                .for_each(|(key, count)| *into.entry(key).or_default() += count);
        }
        self.cases += other.cases;
        for (asked, [primitives, meshes]) in other.proved {
            let counts = self.proved.entry(asked).or_default();
            *counts = [counts[0] + primitives, counts[1] + meshes];
        }
        self.near += other.near;
        self.attached += other.attached;
        join(&mut self.by_kind, other.by_kind);
        join(&mut self.by_format, other.by_format);
        join(&mut self.by_form, other.by_form);
        join(&mut self.by_step, other.by_step);
        join(&mut self.by_text, other.by_text);
        join(&mut self.by_theme, other.by_theme);
        join(&mut self.refused, other.refused);
        join(&mut self.unread, other.unread);
        self.refuted.extend(other.refuted);
    }

    fn segments(&self, asked: &[Asked]) -> u64 {
        asked
            .iter()
            .filter_map(|asked| self.proved.get(asked))
            .flatten()
            .sum()
    }

    /// Fails where so little of a kind was proved that nothing is said about it.
    pub fn assert_says_something(&self) {
        let all = self.segments(&[
            Asked::Check,
            Asked::Shorten,
            Asked::CommandCheck,
            Asked::Export,
        ]);
        assert!(
            self.near * 20 > all,
            "of {all} proved segments only {} come near anything",
            self.near
        );
        assert!(
            self.segments(&[Asked::Shorten]) * 20 > all,
            "too few answers of shorten"
        );
        for asked in [Asked::CommandCheck, Asked::Export] {
            assert!(self.segments(&[asked]) >= 10, "{asked:?} proved too little");
        }
        let enough = |what: &dyn fmt::Debug, count: Option<&u64>, least: u64| {
            let count = count.copied().unwrap_or_default();
            assert!(
                count >= least,
                "{what:?}: {count} proved segments, at least {least} are needed"
            );
        };
        Kind::MOVING
            .iter()
            .for_each(|kind| enough(kind, self.by_kind.get(kind), 300));
        let formats = Format::FILES.iter().chain([&Format::Inline]);
        formats.for_each(|format| enough(format, self.by_format.get(format), 100));
        let forms = [Form::Box, Form::Star, Form::Comb, Form::Roof];
        forms
            .iter()
            .for_each(|form| enough(form, self.by_form.get(form), 100));
        let texts = [Text::Own, Text::Diff, Text::Message, Text::Lines];
        texts
            .iter()
            .for_each(|text| enough(text, self.by_text.get(text), 100));
        enough(&"attached objects", Some(&self.attached), 300);
        for step in [
            Step::Walk,
            Step::Winding,
            Step::Blind,
            Step::Graze,
            Step::Rounded,
            Step::Rewound,
            Step::Signs,
        ] {
            enough(&step, self.by_step.get(&step), 30);
        }
        for step in [Step::HalfTurn, Step::Long] {
            enough(&step, self.by_step.get(&step), 10);
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<14} {:>12} {:>12}   proved segments",
            "", "primitives", "with meshes"
        )?;
        for (asked, [primitives, meshes]) in &self.proved {
            writeln!(
                f,
                "{:<14} {primitives:>12} {meshes:>12}",
                format!("{asked:?}")
            )?;
        }
        let all: u64 = self.proved.values().flatten().sum();
        let share = 100.0 * self.near as f64 / (all as f64).max(1.0);
        writeln!(
            f,
            "all {all}, {share:.0} % of them nearer than {} cm to a collision",
            NEAR_M * 100.0
        )?;
        let formats = self
            .by_format
            .iter()
            .map(|(format, count)| (format.name(), *count));
        writeln!(f, "joints   {:?}", self.by_kind)?;
        writeln!(
            f,
            "meshes   {:?} {:?}",
            formats.collect::<BTreeMap<_, _>>(),
            self.by_form
        )?;
        writeln!(f, "steps    {:?}", self.by_step)?;
        writeln!(
            f,
            "scenes   {:?}, with attached objects {}",
            self.by_text, self.attached
        )?;
        writeln!(f, "themes   {:?}", self.by_theme)?;
        writeln!(f, "refused  {:?}", self.refused)?;
        let unread: u64 = self.unread.values().sum();
        writeln!(f, "unread   {unread}")?;
        for ((theme, reason), count) in &self.unread {
            writeln!(f, "  {count:>6} {theme:?}: {reason}")?;
        }
        writeln!(f, "refuted  {}", self.refuted.len())?;
        let mut told = BTreeMap::new();
        for found in &self.refuted {
            let Refuted {
                case,
                theme,
                asked,
                steps,
                what,
                folder,
                after,
            } = found;
            let count: &mut usize = told.entry((theme, asked)).or_default();
            *count += 1;
            if *count <= MOST_TOLD {
                writeln!(
                    f,
                    "  case {case} {theme:?} {asked:?} {steps:?} after {after}: {what}\n      {folder}"
                )?;
            }
        }
        told.iter()
            .try_for_each(|((theme, asked), count)| writeln!(f, "  {count:>6} {theme:?} {asked:?}"))
    }
}

/// A time for people.
pub fn minutes(time: Duration) -> String {
    format!("{:.1} min", time.as_secs_f64() / 60.0)
}
