//! Follows a job: looks at it, submits lost parts again, says how it goes.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};

use super::job::Job;
use super::tools::{self, Trouble};
use crate::cli::{Context, Exit, Failure, out};
use powergs_study::slurm::Settings;
use powergs_study::slurm::state::{Loss, State, Verdict, given_up, judge, states};

/// How long Slurm may be away before following ends.
const PATIENCE: Duration = Duration::from_secs(15 * 60);

/// Looks at a part that ended without an exit code before it is taken for lost.
const UNCLEAR_LOOKS: u32 = 3;

/// How often Ctrl-C is polled.
const TICK: Duration = Duration::from_millis(100);

/// Parts that are named one by one in a message.
const NAMED: usize = 10;

/// How following ended.
#[derive(Debug)]
pub enum End {
    /// All parts are complete.
    Complete,
    /// Ctrl-C: the job runs on.
    Left,
    /// Parts failed, were cancelled, or were lost too often.
    Incomplete(Failure),
}

/// What is known of one part.
#[derive(Debug, Clone)]
struct FollowPart {
    verdict: Verdict,
    state: Option<State>,
    retries: u32,
    unclear: u32,
}

/// Follows the jobs of a run.
#[derive(Debug)]
pub struct Follower<'a> {
    job: &'a mut Job,
    settings: &'a Settings,
    context: &'a Context,
    /// Part `i` is at `i - 1`.
    parts: Vec<FollowPart>,
    bar: Option<ProgressBar>,
    said: String,
    away_since: Option<Instant>,
}

impl<'a> Follower<'a> {
    /// Nothing is asked or submitted yet.
    pub fn new(job: &'a mut Job, settings: &'a Settings, context: &'a Context) -> Self {
        let fresh = FollowPart { verdict: Verdict::Open, state: None, retries: 0, unclear: 0 };
        let parts = vec![fresh; settings.shards as usize];
        let shown = !context.global.quiet && std::io::stderr().is_terminal();
        let bar = shown.then(|| bar(u64::from(settings.shards)));
        Self { job, settings, context, parts, bar, said: String::new(), away_since: None }
    }

    /// Submits what was never submitted, or ended badly before; then follows to the end.
    pub fn run(mut self) -> Result<End, Failure> {
        let again = self.job.is_submitted();
        if again {
            let jobs: Vec<String> = self.job.live().collect();
            self.say(&format!("following job {}", jobs.join(", ")));
            self.look()?;
            self.say_losses(&self.where_verdict(|v| matches!(v, Verdict::Lost(_))));
        }
        let wanted = self.where_verdict(|v| match v {
            Verdict::Open | Verdict::Unclear => !again,
            Verdict::Done => false,
            Verdict::Lost(_) | Verdict::Failed(_) | Verdict::Cancelled => true,
        });
        let never = self.never_submitted();
        let mut wanted: Vec<u32> = wanted.into_iter().chain(never).collect();
        wanted.sort_unstable();
        wanted.dedup();
        if !wanted.is_empty() {
            self.submit(&wanted).map_err(Trouble::failure)??;
        }
        loop {
            if self.context.is_cancelled() {
                return Ok(End::Left);
            }
            self.look()?;
            self.retry()?;
            self.progress();
            if !self.parts.iter().any(|p| is_open(p.verdict) || self.may_retry(p)) {
                return Ok(self.end());
            }
            self.wait();
        }
    }

    fn where_verdict(&self, wanted: impl Fn(Verdict) -> bool) -> Vec<u32> {
        let numbered = self.parts.iter().zip(1..);
        numbered.filter(|(p, _)| wanted(p.verdict)).map(|(_, part)| part).collect()
    }

    fn never_submitted(&self) -> Vec<u32> {
        let mut known = vec![false; self.parts.len()];
        for (_, parts) in self.job.latest() {
            parts.iter().for_each(|part| known[*part as usize - 1] = true);
        }
        known.iter().zip(1..).filter(|(known, _)| !**known).map(|(_, part)| part).collect()
    }

    fn may_retry(&self, part: &FollowPart) -> bool {
        matches!(part.verdict, Verdict::Lost(_)) && part.retries < self.settings.retries
    }

    /// Submits parts. The outer error is Slurm's, the inner one that of the folder.
    fn submit(&mut self, parts: &[u32]) -> Result<Result<(), Failure>, Trouble> {
        let job = tools::sbatch(&self.job.script(), parts, self.settings.at_once)?;
        let many = if parts.len() == 1 { "part" } else { "parts" };
        self.say(&format!("job {}: submitted {} {many}", job.id, parts.len()));
        for part in parts {
            let part = &mut self.parts[*part as usize - 1];
            (part.verdict, part.state, part.unclear) = (Verdict::Open, None, 0);
        }
        Ok(self.job.note(job, parts))
    }

    /// Asks Slurm and the folder about every part that is open.
    fn look(&mut self) -> Result<(), Failure> {
        for (job, parts) in self.job.latest() {
            let open: Vec<u32> = parts.into_iter().filter(|p| self.is_open(*p)).collect();
            if open.is_empty() {
                continue;
            }
            let mut listed = match tools::squeue(&job) {
                Ok(text) => Some(states(&text, &job.id)),
                Err(trouble) => {
                    self.away(trouble)?;
                    None
                }
            };
            let noted: BTreeMap<u32, u8> =
                open.iter().filter_map(|p| Some((*p, self.job.exit_code(&job.id, *p)?))).collect();
            if let Some(listed) = &mut listed {
                self.away_since = None;
                if open.iter().any(|p| !listed.contains_key(p) && !noted.contains_key(p)) {
                    let accounted = states(&tools::sacct(&job), &job.id);
                    for (part, state) in accounted {
                        listed.entry(part).or_insert(state);
                    }
                }
            }
            for number in open {
                let state = match &listed {
                    Some(listed) => listed.get(&number).cloned(),
                    // Slurm does not answer: as if it ran, unless it says itself that it is done.
                    None => Some(State::Running),
                };
                self.judge(number, state, noted.get(&number).copied());
            }
        }
        Ok(())
    }

    fn is_open(&self, part: u32) -> bool {
        is_open(self.parts[part as usize - 1].verdict)
    }

    fn judge(&mut self, number: u32, state: Option<State>, exit: Option<u8>) {
        let part = &mut self.parts[number as usize - 1];
        part.verdict = judge(state.as_ref(), exit);
        part.unclear = if part.verdict == Verdict::Unclear { part.unclear + 1 } else { 0 };
        if part.unclear >= UNCLEAR_LOOKS {
            part.verdict = Verdict::Lost(given_up(state.as_ref()));
        }
        part.state = state;
    }

    /// Slurm did not answer; gives up after a while.
    fn away(&mut self, trouble: Trouble) -> Result<(), Failure> {
        let Trouble::Failed(message) = trouble else { return Err(trouble.failure()) };
        let since = *self.away_since.get_or_insert_with(Instant::now);
        if since.elapsed() > PATIENCE {
            let minutes = PATIENCE.as_secs() / 60;
            let text = format!(
                "{message}\n  Slurm has not answered for {minutes} minutes. The job is not \
                 touched; the same command with --resume follows it again"
            );
            return Err(Failure::new(Exit::Usage, text));
        }
        self.say(&format!("{message} (asking again)"));
        Ok(())
    }

    /// Submits lost parts again, those that may be.
    fn retry(&mut self) -> Result<(), Failure> {
        let numbered = self.parts.iter().zip(1..);
        let lost: Vec<u32> = numbered.filter(|(p, _)| self.may_retry(p)).map(|(_, n)| n).collect();
        if lost.is_empty() || self.context.is_cancelled() {
            return Ok(());
        }
        self.say_losses(&lost);
        match self.submit(&lost) {
            Ok(noted) => {
                lost.iter().for_each(|n| self.parts[*n as usize - 1].retries += 1);
                noted
            }
            // They stay lost and are tried again at the next look.
            Err(trouble) => self.away(trouble),
        }
    }

    /// Why parts are submitted again.
    fn say_losses(&mut self, lost: &[u32]) {
        let mut by_loss: BTreeMap<Loss, Vec<u32>> = BTreeMap::new();
        for part in lost {
            if let Verdict::Lost(loss) = self.parts[*part as usize - 1].verdict {
                by_loss.entry(loss).or_default().push(*part);
            }
        }
        for (loss, parts) in by_loss {
            self.say(&format!("lost {}: {loss}", named(&parts)));
        }
    }

    fn progress(&mut self) {
        let count =
            |wanted: fn(&FollowPart) -> bool| self.parts.iter().filter(|p| wanted(p)).count();
        let done = count(|p| p.verdict == Verdict::Done);
        let running = count(|p| is_open(p.verdict) && p.state == Some(State::Running));
        let waiting = count(|p| is_open(p.verdict)) - running;
        let bad = self.parts.len() - done - running - waiting;
        let reason = self.parts.iter().find_map(|p| match &p.state {
            Some(State::Pending(why)) if is_open(p.verdict) && why != "None" => Some(why.as_str()),
            _ => None,
        });
        let why = reason.filter(|r| !r.is_empty()).map_or(String::new(), |r| format!(" ({r})"));
        let failed = if bad > 0 { format!(", {bad} failed") } else { String::new() };
        let text = format!("{running} running, {waiting} waiting{why}{failed}");
        match &self.bar {
            Some(bar) => {
                bar.set_position(done as u64);
                bar.set_message(text);
            }
            None => {
                let all = self.parts.len();
                self.say(&format!("{done} of {all} parts done, {text}"));
            }
        }
    }

    /// Prints a line, once.
    fn say(&mut self, line: &str) {
        if self.context.global.quiet || self.said == line {
            return;
        }
        line.clone_into(&mut self.said);
        match &self.bar {
            Some(bar) => bar.suspend(|| out::complain(line)),
            None => out::complain(line),
        }
    }

    fn wait(&self) {
        let until = Instant::now() + Duration::from_secs_f64(self.settings.poll_s());
        while Instant::now() < until && !self.context.is_cancelled() {
            std::thread::sleep(TICK.min(until.saturating_duration_since(Instant::now())));
        }
    }

    /// All parts have ended.
    fn end(&self) -> End {
        let bad = self.where_verdict(|v| v != Verdict::Done);
        if bad.is_empty() {
            return End::Complete;
        }
        let mut job_of = BTreeMap::new();
        for (job, parts) in self.job.latest() {
            parts.into_iter().for_each(|p| drop(job_of.insert(p, job.id.clone())));
        }
        let mut exit = Exit::GoalMissed;
        let mut text = format!("{} of {} parts are not complete", bad.len(), self.parts.len());
        for number in bad.iter().take(NAMED) {
            let verdict = self.parts[*number as usize - 1].verdict;
            let why = match verdict {
                Verdict::Lost(loss) => format!("{loss}, {} retries", self.settings.retries),
                Verdict::Failed(code) => format!("the program ended with exit code {code}"),
                Verdict::Cancelled => "cancelled".to_owned(),
                Verdict::Open | Verdict::Unclear | Verdict::Done => String::new(),
            };
            let job = job_of.get(number).map_or("", String::as_str);
            let (path, last) = self.job.log(job, *number);
            text.push_str(&format!("\n  part {number}: {why}; log: {}", path.display()));
            last.into_iter().for_each(|line| text.push_str(&format!("\n    {line}")));
            exit = match verdict {
                Verdict::Failed(3) if exit != Exit::Internal => Exit::BadInput,
                Verdict::Failed(4) => Exit::Internal,
                _ => exit,
            };
        }
        if bad.len() > NAMED {
            text.push_str(&format!("\n  and {} more", bad.len() - NAMED));
        }
        text.push_str("\n  the same command with --resume submits these parts again");
        End::Incomplete(Failure::new(exit, text))
    }
}

fn is_open(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::Open | Verdict::Unclear)
}

/// `part 3` or `parts 3, 5 and 7 more`.
fn named(parts: &[u32]) -> String {
    let list: Vec<String> = parts.iter().take(NAMED).map(u32::to_string).collect();
    let many = if parts.len() == 1 { "part" } else { "parts" };
    let more = parts.len() - list.len();
    let rest = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{many} {}{rest}", list.join(", "))
}

fn bar(parts: u64) -> ProgressBar {
    let bar = ProgressBar::with_draw_target(Some(parts), ProgressDrawTarget::stderr());
    let style = ProgressStyle::with_template("{bar:24} {pos}/{len} parts done, {msg}");
    bar.set_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()));
    bar
}
