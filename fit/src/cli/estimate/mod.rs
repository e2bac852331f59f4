//! `fit estimate`: a, c and mu from a campaign of photographs.

mod arguments;
mod summary;

pub(crate) use arguments::Arguments;

use std::collections::{BTreeMap, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;
use tables::cli as terminal;

use tables::{Output, Outputs, Table};

use crate::cli::estimate::arguments::{options, several};
use crate::cli::estimate::summary::summary;
use crate::cli::failure::Failure;
use crate::cli::host::Caller;
use crate::cli::options::expected::{self, Expected};
use crate::cli::options::parse;
use crate::cli::output;
use crate::cli::progress::Bar;
use edges::names::Family;
use edges::photographs::manifest::captures;
use edges::photographs::photo::channel::Channel;
use edges::photographs::photo::in_memory::InMemory;
use edges::photographs::{Campaign, Shot};
use estimator::estimate::OtherTable;
use estimator::estimate::Progress;
use estimator::estimate::campaign::undiagnosed;
use estimator::estimate::scene::Source;
use estimator::estimate::{Estimated, Options};
use estimator::result::ResultFile;
use estimator::result::TableResult;
use estimator::result::Truth;
#[cfg(feature = "full")]
use pictures::report::page::evidence::Evidence;
#[cfg(feature = "full")]
use pictures::report::page::shown::Page;
#[cfg(feature = "full")]
use pictures::report::plot;

/// Runs the verb.
///
/// # Errors
/// Fails if the manifest, a photograph or the table cannot be used, if the estimate fails, or if an
/// output cannot be written.
pub(crate) fn run(arguments: &Arguments) -> Result<(), Failure> {
    let mut options = options(arguments)?;
    #[cfg(feature = "full")]
    if several(arguments).is_some() && (arguments.plot.is_some() || arguments.report.is_some()) {
        return Err(Failure::conflict(
            "fit estimate",
            "--plot and --report show one fit; name one --channel for them",
        ));
    }
    let start = Instant::now();
    let option = arguments.expect_table.as_deref();
    let (campaign, expected) = expected::campaign(&arguments.captures, option)?;
    let mut outputs = Outputs::beside(inputs(arguments, &campaign));
    let output = terminal::reserve(arguments.output.as_deref(), &mut outputs)?;
    #[cfg(feature = "full")]
    let picture = terminal::reserve_plot(arguments.plot.as_deref(), &mut outputs)?;
    #[cfg(feature = "full")]
    let page = terminal::reserve(arguments.report.as_deref(), &mut outputs)?;
    let truth: Option<Truth> = arguments
        .truth
        .as_deref()
        .map(|path| parse::read_json(path, "holds a planted answer"))
        .transpose()?;
    let pool = terminal::pool(arguments.threads)?;
    let table = pool.install(|| read_tables(arguments, &expected, &mut options.others))?;
    let options = options;
    let job = Job {
        arguments,
        campaign: &campaign,
        table: &table,
    };
    if let Some(channels) = several(arguments) {
        let results = pool.install(|| job.each_channel(&options, channels))?;
        let json = output::json(&results);
        if let Some(output) = output {
            output.commit(json.as_bytes())?;
        }
        let tables = results
            .iter()
            .map(|(channel, result)| format!("{channel}\n{}", summary(result, truth.as_ref())));
        return Ok(terminal::print(&if arguments.json {
            json
        } else {
            tables.collect::<Vec<_>>().join("\n")
        })?);
    }
    #[cfg_attr(
        not(feature = "full"),
        expect(unused_variables, reason = "the page shows it")
    )]
    let (estimated, result) = pool.install(|| job.run(&options, start, output.as_ref()))?;
    warn(&result, "");
    let json = output::json(&result);
    #[cfg(feature = "full")]
    if let Some(output) = picture {
        output.commit(plot::fitted(&result).as_bytes())?;
    }
    #[cfg(feature = "full")]
    if let Some(page) = page {
        let evidence = pool.install(|| Evidence::of(&estimated));
        let table = result.seen(&table)?;
        let shown = Page {
            result: &result,
            table: &table,
            campaign: &estimated.campaign,
            truth: truth.as_ref(),
            evidence: &evidence,
            command: &output::command_line(std::env::args_os()),
        };
        page.commit(pool.install(|| shown.html()).as_bytes())?;
    }
    if let Some(output) = output {
        output.commit(json.as_bytes())?;
    }
    Ok(terminal::print(&if arguments.json {
        json
    } else {
        summary(&result, truth.as_ref())
    })?)
}

/// Inputs of an estimate that another program calls.
pub(super) struct Inputs<'a> {
    /// Text of the manifest, and the photographs that it names; `None` if both are files.
    pub(super) held: Option<(String, HashMap<PathBuf, InMemory>)>,
    /// Table of the sheet.
    pub(super) table: &'a Arc<Table>,
    /// Further tables.
    pub(super) others: Vec<OtherTable>,
}

/// Estimate that another program called.
pub(super) struct Estimation {
    estimated: Estimated,
    table: Arc<Table>,
    pub(super) result: ResultFile,
}

impl Estimation {
    /// Returns the page of the estimate as HTML; `command` is said to have made it.
    #[cfg(feature = "full")]
    pub(super) fn report(&self, command: &str) -> String {
        let evidence = Evidence::of(&self.estimated);
        let shown = Page {
            result: &self.result,
            table: &self.table,
            campaign: &self.estimated.campaign,
            truth: None,
            evidence: &evidence,
            command,
        };
        shown.html()
    }
}

/// Makes the estimate that another program calls. Nothing is printed or written.
///
/// # Errors
/// Fails as [`run`] does, and with [`estimator::Error::Cancelled`] if the caller stopped it.
pub(super) fn called(
    arguments: &Arguments,
    inputs: Inputs,
    caller: Caller,
    start: Instant,
) -> Result<Estimation, Failure> {
    let mut options = options(arguments)?;
    if several(arguments).is_some() {
        let message = "a call fits one channel; call once for each channel";
        return Err(Failure::conflict("fit estimate", message));
    }
    options.others = inputs.others;
    let option = arguments.expect_table.as_deref();
    let (manifest, photographs) = inputs.held.unzip();
    let photographs = photographs.unwrap_or_default();
    let (campaign, expected) = match manifest {
        Some(text) => {
            let is_held = |image: &Path| photographs.contains_key(image) || image.is_file();
            expected::of(captures::held(text, &arguments.captures, &is_held)?, option)?
        }
        None => expected::campaign(&arguments.captures, option)?,
    };
    expected.check(inputs.table, arguments.first_table())?;
    let supply = |shot: &Shot| match photographs.get(&shot.image) {
        Some(held) => shot.held(held),
        None => shot.load(),
    };
    let progress = Progress {
        report: Some(&|step| caller.show(step)),
        cancel: Some(caller.stop),
    };
    let job = Job {
        arguments,
        campaign: &campaign,
        table: inputs.table,
    };
    let pool = terminal::pool(arguments.threads)?;
    let early = |_: &ResultFile| Ok(());
    let made = pool.install(|| job.reported(&supply, &options, start, (&progress, &early)));
    let (estimated, result) = made?;
    Ok(Estimation {
        estimated,
        table: Arc::clone(inputs.table),
        result,
    })
}

/// Returns the files that are read. None of them may be an output.
fn inputs<'a>(arguments: &'a Arguments, campaign: &'a Campaign) -> impl Iterator<Item = &'a Path> {
    let captures = campaign.captures.iter().map(|capture| &capture.shot);
    let shots = campaign.references.iter().chain(captures);
    let tables = arguments.table.iter().map(PathBuf::as_path);
    tables
        .chain([arguments.captures.as_path()])
        .chain(arguments.truth.as_deref())
        .chain(shots.map(|shot| shot.image.as_path()))
}

/// Arguments, photographs and table of one estimate.
struct Job<'a> {
    arguments: &'a Arguments,
    campaign: &'a Campaign,
    table: &'a Table,
}

impl Job<'_> {
    /// Makes one estimate, and the result that is written of it. A first result is written to
    /// `output` before the search for mistakes, which may take long.
    fn run(
        &self,
        options: &Options,
        start: Instant,
        output: Option<&Output>,
    ) -> Result<(Estimated, ResultFile), Failure> {
        let bar = Bar::of_steps();
        let progress = Progress {
            report: Some(&|step| bar.show(step)),
            cancel: None,
        };
        let early = |result: &ResultFile| match output {
            Some(output) => Ok(output.commit(output::json(result).as_bytes())?),
            None => Ok(()),
        };
        let made = self.reported(&Shot::load, options, start, (&progress, &early));
        bar.done();
        made
    }

    /// Makes one estimate of the photographs that `photo` supplies. `early` gets the result before
    /// the search for mistakes, if there is one.
    fn reported(
        &self,
        photo: &Source,
        options: &Options,
        start: Instant,
        (progress, early): (&Progress, &Early<'_>),
    ) -> Result<(Estimated, ResultFile), Failure> {
        let table = self.table;
        let estimated = undiagnosed(self.campaign, photo, table, options, progress);
        let mut estimated = estimated.map_err(|error| match error {
            estimator::Error::OneAzimuth(held) => Failure::OneAzimuth {
                table: self.arguments.first_table().to_owned(),
                held,
            },
            error => error.into(),
        })?;
        let result = |estimated: &Estimated| {
            let seconds = start.elapsed().as_secs_f64();
            ResultFile::new(estimated, TableResult::of(table), seconds)
        };
        if estimated.needs_diagnosis(options) {
            early(&result(&estimated))?;
        }
        estimated.diagnose(photo, table, options, progress)?;
        let result = result(&estimated);
        Ok((estimated, result))
    }

    /// Makes one estimate for each channel, and returns the results by the name of the channel.
    fn each_channel(
        &self,
        options: &Options,
        channels: &[Channel],
    ) -> Result<BTreeMap<String, ResultFile>, Failure> {
        let one = |channel: &Channel| {
            let options = Options {
                channel: Some(channel.clone()),
                ..options.clone()
            };
            let (_, result) = self.run(&options, Instant::now(), None)?;
            warn(&result, &format!("{channel}: "));
            Ok((channel.to_string(), result))
        };
        channels.iter().map(one).collect()
    }
}

/// Function that gets a result before its mistakes are searched for.
type Early<'a> = dyn Fn(&ResultFile) -> Result<(), Failure> + 'a;

/// Prints the warnings of a result, each with `before` in front of it.
fn warn(result: &ResultFile, before: &str) {
    for warning in &result.warnings {
        terminal::warn([format!("{before}{warning}")]);
    }
    for capture in &result.captures {
        for warning in &capture.warnings {
            terminal::warn([format!("{before}{}: {warning}", capture.image)]);
        }
    }
}

/// Reads the table, and adds the further ones to `others`.
///
/// # Errors
/// Fails if a table cannot be read, or if the first one is not the expected one.
fn read_tables(
    arguments: &Arguments,
    expected: &Expected,
    others: &mut Vec<OtherTable>,
) -> Result<Table, Failure> {
    let table = expected.read(arguments.first_table())?;
    for path in arguments.table.iter().skip(1) {
        others.push(OtherTable::read(path)?);
    }
    Ok(table)
}

/// Reads a RESULT.json of one fit.
///
/// # Errors
/// Returns [`Failure::Json`] if the file cannot be read or holds no result. Returns
/// [`Failure::Channel`] if it holds one result for each of several channels.
pub(crate) fn read_result(path: &Path) -> Result<ResultFile, Failure> {
    read_channel(path, None)
}

/// Checks that a result is of the model that was named, if one was named.
///
/// # Errors
/// Returns [`Failure::Model`] if the result is of another model.
pub(crate) fn check_model(
    path: &Path,
    result: &ResultFile,
    model: Option<Family>,
) -> Result<(), Failure> {
    match model {
        Some(asked) if asked != result.model => Err(Failure::Model {
            path: path.to_owned(),
            asked,
        }),
        _ => Ok(()),
    }
}

/// Reads a RESULT.json: of one fit, or the named channel of a file with several channels.
///
/// # Errors
/// Returns [`Failure::Json`] if the file cannot be read, holds no result, or one of a sheet or a
/// camera that cannot be. Returns [`Failure::Channel`] if it holds several channels and `channel` names none of
/// them.
pub(crate) fn read_channel(path: &Path, channel: Option<&str>) -> Result<ResultFile, Failure> {
    let expected = "`fit estimate -o` wrote";
    let several = || parse::read_json::<BTreeMap<String, ResultFile>>(path, expected);
    let channels = |held: BTreeMap<String, ResultFile>| Failure::Channel {
        path: path.to_owned(),
        held: held.into_keys().collect::<Vec<_>>().join(", "),
    };
    let result: ResultFile = match channel {
        None => parse::read_json(path, expected)
            .map_err(|failure| several().map_or(failure, channels))?,
        Some(name) => {
            let mut held = several()?;
            held.remove(name).ok_or_else(|| channels(held))?
        }
    };
    match result.check() {
        Err(estimator::Error::Number {
            what,
            value,
            must_be,
        }) => Err(Failure::Json {
            path: path.to_owned(),
            message: format!("`{what}` is {value} but must be {must_be}"),
            expected,
        }),
        checked => Ok(checked.map(|()| result)?),
    }
}
