//! The kernels of the wide tree as the compiler wrote them: their hot loops call nothing and spill no more than is known.
//!
//! What goes wrong without a word: a closure that is not compiled for the instruction set, so that each vector operation in it is
//! a call; a value more than there are registers. Neither changes an answer, and only a measurement on the right machine
//! would tell.

mod listing;

use crate::shell::{command, step, target};
use anyhow::{Context, Result, ensure};
use listing::{Function, Instruction, Tables};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// The instruction sets of x86-64, in the order of the budgets; their names in symbols.
const SETS: [(&str, &str); 4] = [
    ("avx512", "::Avx512"),
    ("avx2", "::Avx2"),
    ("sse4.2", "::Sse4_2"),
    ("sse2", "::Sse2"),
];

/// What a loop is known by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Step {
    /// Tests boxes, which it compares as integers.
    Node,
    /// Tests triangles: the least and the largest of their edge functions.
    Leaf,
}

/// A hot loop.
struct Kernel {
    name: &'static str,
    /// All of this is in the name of its function.
    function: &'static [&'static str],
    step: Step,
    /// Moves of vectors to the stack and from there, by instruction set; none where the kernel is not used.
    budget: [Option<usize>; 4],
}

const CLOSEST: &[&str] = &[
    FULL,
    "WideTriangles",
    "as boxwood::query::Query>::closest_hit",
];
const OCCLUDED: &[&str] = &[FULL, "WideTriangles", "as boxwood::query::Query>::occluded"];
const BATCH_CLOSEST: &[&str] = &[FULL, "wide::batch::run", "::ClosestHits"];
const BATCH_OCCLUDED: &[&str] = &[FULL, "wide::batch::run", "::OccludedEach"];
const BUNDLE_CLOSEST: &[&str] = &[FULL, "wide::bundle::trace_alike", "::ClosestHits"];
const BUNDLE_OCCLUDED: &[&str] = &[FULL, "wide::bundle::trace_alike", "::OccludedEach"];
const NEAREST: &[&str] = &[
    FULL,
    "WideTriangles",
    "as boxwood::query::Query>::nearest_each",
];
const LISTS: &[&str] = &[FULL, "wide::batch::run", "::Lists"];
const NUMBERS: &[&str] = &[FULL, "wide::batch::run", "::Numbers"];
/// The form for speed; the other's kernels unpack through the stack.
const FULL: &str = "wide::full::Full";

/// The compiler that the budgets were measured with. With another, more spills are told and are no failure.
const COMPILER: &str = "rustc 1.95.";

/// Every hot loop, with what was measured. Eight lanes in two halves, on 16 registers, must spill; and what a ray is made of comes
/// back from the stack after each call of what is cold. Leaves of bundles are not told apart from what surrounds them.
const KERNELS: &[Kernel] = &[
    kernel("single closest, node", CLOSEST, Step::Node, [0, 2, 124, 75]),
    kernel(
        "single closest, leaf",
        CLOSEST,
        Step::Leaf,
        [43, 29, 124, 75],
    ),
    kernel(
        "single occluded, node",
        OCCLUDED,
        Step::Node,
        [28, 55, 84, 84],
    ),
    kernel(
        "single occluded, leaf",
        OCCLUDED,
        Step::Leaf,
        [28, 55, 84, 84],
    ),
    eight("batch closest, node", BATCH_CLOSEST, Step::Node, [0, 0]),
    eight("batch closest, leaf", BATCH_CLOSEST, Step::Leaf, [10, 14]),
    eight("batch occluded, node", BATCH_OCCLUDED, Step::Node, [0, 0]),
    eight("batch occluded, leaf", BATCH_OCCLUDED, Step::Leaf, [0, 0]),
    kernel(
        "bundle closest, node",
        BUNDLE_CLOSEST,
        Step::Node,
        [7, 21, 25, 26],
    ),
    kernel(
        "bundle occluded, node",
        BUNDLE_OCCLUDED,
        Step::Node,
        [14, 19, 24, 24],
    ),
    kernel(
        "nearest, node and leaf",
        NEAREST,
        Step::Leaf,
        [11, 42, 127, 160],
    ),
    kernel("lists, node", LISTS, Step::Node, [0, 0, 5, 6]),
    kernel("lists, leaf", LISTS, Step::Leaf, [0, 0, 48, 48]),
    kernel("numbers, node", NUMBERS, Step::Node, [0, 0, 5, 6]),
    kernel("numbers, leaf", NUMBERS, Step::Leaf, [0, 0, 48, 48]),
];

/// What hot loops may call, and why.
const COLD: &[(&str, &str)] = &[
    (
        "single::consider",
        "once for each leaf with a candidate; apart, so that the loop keeps its registers",
    ),
    ("single::is_blocking", "the same"),
    (
        "Pending>::settle",
        "when more leaves wait than there is room for, or at a ray's end",
    ),
    ("batch::flush", "for every eighth ray"),
    (
        "Pending>::decide_now",
        "the exact test, where the fast one cannot tell",
    ),
    ("any_exact", "the same"),
    ("every::decide_now", "the same"),
    ("Lists>::flush", "for every eighth hit"),
    (
        "nearest::Search>::settle",
        "for the last few triangles of a point",
    ),
];

/// What may call vector operations, each of them a call, and why.
const SLOW: &[(&str, &str)] = &[
    (
        "binned::Frame",
        "sets that no border divides: `halve` is cold",
    ),
    (
        "explain::Teller",
        "a build that tells its steps takes its time",
    ),
];

const fn kernel(
    name: &'static str,
    function: &'static [&'static str],
    step: Step,
    [a, b, c, d]: [usize; 4],
) -> Kernel {
    let budget = [Some(a), Some(b), Some(c), Some(d)];
    Kernel {
        name,
        function,
        step,
        budget,
    }
}

/// Of registers with eight lanes only.
const fn eight(
    name: &'static str,
    function: &'static [&'static str],
    step: Step,
    [a, b]: [usize; 2],
) -> Kernel {
    let budget = [Some(a), Some(b), None, None];
    Kernel {
        name,
        function,
        step,
        budget,
    }
}

/// Compiles the library to assembly, or takes the file that is named, and looks at all kernels.
pub(crate) fn run(args: &[String]) -> Result<()> {
    if !cfg!(all(target_arch = "x86_64", target_os = "linux")) {
        println!("skipped: the kernels' assembly is read as written for x86-64 on Linux");
        return Ok(());
    }
    let path = args.first().map_or_else(compile, |path| Ok(path.into()))?;
    let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    let compiler = command("rustc", &["--version"]).output()?.stdout;
    let report = examine(&text, KERNELS, compiler.starts_with(COMPILER.as_bytes()));
    println!("{}", report.table);
    report
        .notes
        .iter()
        .for_each(|note| println!("note: {note}"));
    ensure!(report.failures.is_empty(), "{}", report.failures.join("\n"));
    Ok(())
}

/// One unit, so that no function depends on how the crate is cut; names that tell types.
fn compile() -> Result<PathBuf> {
    let path = target().join("boxwood.s");
    let emit = format!("--emit=asm={}", path.display());
    let mut cargo = command(
        "cargo",
        &["rustc", "--release", "--package", "boxwood", "--lib", "--"],
    );
    cargo.args([&emit, "-Ccodegen-units=1", "-Csymbol-mangling-version=v0"]);
    step("assembly", cargo)?;
    Ok(path)
}

/// What was found.
struct Report {
    table: String,
    notes: Vec<String>,
    failures: Vec<String>,
}

fn examine(text: &str, kernels: &[Kernel], spills_count: bool) -> Report {
    let (functions, tables) = listing::read(text);
    let mut report = Report {
        table: format!(
            "{:<22} {:<7} {:>12} {:>6} {:>7} {:>7}\n",
            "kernel", "set", "instructions", "calls", "spills", "budget"
        ),
        notes: Vec::new(),
        failures: functions
            .iter()
            .filter_map(calls_vector_operations)
            .collect(),
    };
    for kernel in kernels {
        for (&(set, symbol), budget) in SETS.iter().zip(kernel.budget) {
            if let Some(budget) = budget {
                let worst = worst(kernel, symbol, &functions, &tables);
                report.add(kernel, set, budget, worst, spills_count);
            }
        }
    }
    report
}

impl Report {
    fn add(
        &mut self,
        kernel: &Kernel,
        set: &str,
        budget: usize,
        found: Option<Shape>,
        spills_count: bool,
    ) {
        let name = kernel.name;
        let Some(shape) = found else {
            self.failures.push(format!(
                "{name}, {set}: no such loop in any function of {:?}: renamed, or its vector operations are calls",
                kernel.function
            ));
            return;
        };
        self.table.push_str(&format!(
            "{name:<22} {set:<7} {:>12} {:>6} {:>7} {budget:>7}\n",
            shape.instructions,
            shape.calls.len(),
            shape.spills
        ));
        for callee in BTreeSet::from_iter(&shape.calls) {
            let text = format!("{name}, {set}: the loop calls {callee}");
            self.failures.push(text);
        }
        if shape.spills > budget {
            let spills = shape.spills;
            let text = format!(
                "{name}, {set}: {spills} vectors to and from the stack, {budget} are known"
            );
            // Where some must be spilled, one more or less comes and goes with code that has nothing to do with it.
            let is_much = spills > budget + budget / 4;
            let list = if spills_count && is_much {
                &mut self.failures
            } else {
                &mut self.notes
            };
            list.push(text);
        }
    }
}

/// A loop in numbers.
#[derive(Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Shape {
    calls: Vec<String>,
    spills: usize,
    instructions: usize,
}

/// The worst of a kernel's variants for an instruction set.
fn worst(
    kernel: &Kernel,
    symbol: &str,
    functions: &[Function<'_>],
    tables: &Tables<'_>,
) -> Option<Shape> {
    functions
        .iter()
        .filter(|of| {
            is_for(&of.name, symbol) && kernel.function.iter().all(|part| has_word(&of.name, part))
        })
        .filter_map(|of| {
            let loops = of.loops(tables).into_iter();
            let hot = loops.max_by_key(|code| kernel.step.count(code))?;
            (kernel.step.count(&hot) >= 4).then(|| shape(of, &hot))
        })
        .max_by(|a, b| (a.calls.len(), a.spills).cmp(&(b.calls.len(), b.spills)))
}

/// True if a function is of an instruction set. What names none is of the least, which all code may use.
fn is_for(name: &str, symbol: &str) -> bool {
    match SETS.iter().find(|(_, symbol)| name.contains(symbol)) {
        Some((_, first)) => *first == symbol,
        None => symbol == SETS[3].1,
    }
}

/// True if `part` is in the name and ends where a word does.
fn has_word(name: &str, part: &str) -> bool {
    name.match_indices(part).any(|(at, _)| {
        let next = name[at + part.len()..].chars().next();
        !next.is_some_and(|c| c.is_alphanumeric() || c == '_')
    })
}

impl Step {
    fn count(self, code: &[Instruction<'_>]) -> usize {
        let marks = match self {
            Self::Node => &["pminsd", "pmaxsd", "pcmpgtd"][..],
            Self::Leaf => &["minps", "maxps"],
        };
        let is_mark = |code: &&Instruction<'_>| marks.contains(&code.op.trim_start_matches('v'));
        code.iter().filter(is_mark).count()
    }
}

fn shape(function: &Function<'_>, code: &[Instruction<'_>]) -> Shape {
    let calls = code.iter().filter_map(Instruction::callee);
    Shape {
        calls: calls
            .filter(|callee| !COLD.iter().any(|(name, _)| callee.contains(name)))
            .collect(),
        spills: code.iter().filter(|code| function.spills(code)).count(),
        instructions: code.len(),
    }
}

/// A complaint about a function in which vector operations are calls.
fn calls_vector_operations(function: &Function<'_>) -> Option<String> {
    let count = function
        .callees()
        .filter(|callee| callee.contains("__fearless_simd_kernel"))
        .count();
    let is_known = || SLOW.iter().any(|(name, _)| function.name.contains(name));
    (count > 0 && !is_known()).then(|| {
        format!(
            "{}: {count} vector operations are calls; it is not compiled for the instruction set (a closure without #[inline(always)]?)",
            function.name
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A function with a loop over nodes that has `inside` in it, and what is cold after it.
    fn text(name: &str, inside: &str) -> String {
        format!(
            "{name}:\n.Lfunc_begin0:\n\tpushq\t%rbp\n\tvmovaps\t%ymm9, 32(%rsp)\n\tcallq\tsetup@PLT\n\
             .LBB0_1:\n\t.loc\t1 2 3\n\tvpminsd\t%ymm0, %ymm1, %ymm0\n\tvpminsd\t(%rdi), %ymm0, %ymm0\n\
             \tvpmaxsd\t%ymm2, %ymm1, %ymm0\n\tvpmaxsd\t%ymm3, %ymm1, %ymm0\n{inside}\tcmpq\t%rax, %rcx\n\
             \tjae\t.LBB0_3\n\tjne\t.LBB0_1\n\tretq\n.LBB0_3:\n\tcallq\tpanic_bounds_check_fail\n.Lfunc_end0:\n"
        )
    }

    const KERNEL: [Kernel; 1] = [Kernel {
        name: "toy",
        function: &["toy"],
        step: Step::Node,
        budget: [None, Some(1), None, None],
    }];

    fn failures(name: &str, inside: &str) -> Vec<String> {
        examine(&text(name, inside), &KERNEL, true).failures
    }

    #[test]
    fn a_loop_is_found_and_what_is_out_of_it_does_not_count() {
        let report = examine(&text("toy::Avx2", ""), &KERNEL, true);
        assert!(report.failures.is_empty(), "{:?}", report.failures);
        let row: Vec<_> = report
            .table
            .lines()
            .last()
            .unwrap_or_default()
            .split_whitespace()
            .collect();
        assert_eq!(row, ["toy", "avx2", "7", "0", "0", "1"]);
    }

    #[test]
    fn a_call_in_the_loop_fails_unless_it_is_known_as_cold() {
        assert_eq!(
            failures("toy::Avx2", "\tcallq\twide::batch::flush\n"),
            [""; 0]
        );
        let found = failures("toy::Avx2", "\tcallq\t*helper@GOTPCREL(%rip)\n");
        assert_eq!(found, ["toy, avx2: the loop calls helper"]);
        assert_eq!(
            failures("toy::Avx2", "\tcallq\t*%r14\n"),
            ["toy, avx2: the loop calls *%r14"]
        );
    }

    #[test]
    fn more_spills_than_known_fail_and_with_another_compiler_are_told() {
        let one = "\tvmovaps\t%ymm0, 64(%rsp)\n";
        let array = "\tvmovaps\t%ymm0, 64(%rsp,%rax)\n\tmovq\t%rax, 8(%rsp)\n\tvmulps\t(%rbp), %ymm0, %ymm0\n";
        assert_eq!(failures("toy::Avx2", &format!("{one}{array}")), [""; 0]);
        let two = text(
            "toy::Avx2",
            &format!("{one}\tvmulps\t64(%rsp), %ymm0, %ymm0\n"),
        );
        let report = examine(&two, &KERNEL, true);
        assert_eq!(
            report.failures,
            ["toy, avx2: 2 vectors to and from the stack, 1 are known"]
        );
        let other = examine(&two, &KERNEL, false);
        assert_eq!((other.failures.len(), other.notes), (0, report.failures));
    }

    #[test]
    fn a_kernel_that_is_not_there_fails() {
        for name in ["toys::Avx2", "toy::Sse2", "toy"] {
            let found = failures(name, "");
            assert!(
                found.len() == 1 && found[0].contains("renamed"),
                "{name}: {found:?}"
            );
        }
    }

    #[test]
    fn a_vector_operation_that_is_a_call_fails_wherever_it_is() {
        let closure = "other::Avx2:\n\tcallq\tadd::__fearless_simd_kernel\n.Lfunc_end1:\n";
        let report = examine(
            &format!("{}{closure}", text("toy::Avx2", "")),
            &KERNEL,
            true,
        );
        assert!(
            report.failures.len() == 1 && report.failures[0].starts_with("other::Avx2: 1 vector")
        );
    }
}
