//! Assembly text (AT&T, ELF) as functions, and functions as loops.

use std::collections::HashMap;
use std::ops::Range;

/// One instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Instruction<'a> {
    /// `vmovaps`.
    pub(super) op: &'a str,
    /// `%ymm0, 352(%rsp)`.
    pub(super) args: &'a str,
}

/// A function as it is written: labels and instructions.
#[derive(Debug)]
pub(super) struct Function<'a> {
    /// Demangled, without hashes.
    pub(super) name: String,
    code: Vec<Instruction<'a>>,
    /// Label, and the instruction that follows it.
    labels: HashMap<&'a str, usize>,
}

/// Jump tables: the labels that each may lead to.
pub(super) type Tables<'a> = HashMap<&'a str, Vec<&'a str>>;

/// All functions and jump tables.
pub(super) fn read(text: &str) -> (Vec<Function<'_>>, Tables<'_>) {
    let (mut functions, mut tables) = (Vec::new(), Tables::new());
    let mut function: Option<Function<'_>> = None;
    let mut table = None;
    for line in text.lines() {
        let line = line
            .split_once('#')
            .map_or(line, |(code, _)| code)
            .trim_end();
        if let Some(label) = line.strip_suffix(':') {
            table = label.starts_with(".LJTI").then_some(label);
            if label.starts_with(".Lfunc_end") {
                functions.extend(function.take());
            } else if label.starts_with('.') {
                if let Some(function) = &mut function {
                    function.labels.insert(label, function.code.len());
                }
            } else {
                let name = format!("{:#}", rustc_demangle::demangle(label));
                function = Some(Function::new(name));
            }
        } else if let (Some(table), Some(entry)) = (table, line.trim().strip_prefix(".long")) {
            let target = entry.split_once('-').map_or(entry, |(target, _)| target);
            tables.entry(table).or_default().push(target.trim());
        } else if let Some(function) = &mut function
            && line.starts_with(char::is_whitespace)
            && !line.trim_start().starts_with('.')
        {
            let line = line.trim();
            let (op, args) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
            function.code.push(Instruction {
                op,
                args: args.trim(),
            });
        }
    }
    (functions, tables)
}

/// Instructions without a branch among them, and the blocks that may follow.
struct Block {
    code: Range<usize>,
    next: Vec<usize>,
}

impl<'a> Function<'a> {
    fn new(name: String) -> Self {
        Self {
            name,
            code: Vec::new(),
            labels: HashMap::new(),
        }
    }

    /// What it calls, each as often as it does.
    pub(super) fn callees(&self) -> impl Iterator<Item = String> {
        self.code.iter().filter_map(Instruction::callee)
    }

    /// Its loops, each with the instructions that are in no loop inside it.
    pub(super) fn loops(&self, tables: &Tables<'_>) -> Vec<Vec<Instruction<'a>>> {
        let blocks = self.blocks(tables);
        let bodies = bodies(&blocks);
        let mut own = vec![Vec::new(); bodies.len()];
        for (at, block) in blocks.iter().enumerate() {
            let around = (0..bodies.len()).filter(|&of| bodies[of][at]);
            if let Some(smallest) = around.min_by_key(|&of| size(&bodies[of])) {
                own[smallest].extend_from_slice(&self.code[block.code.clone()]);
            }
        }
        own
    }

    /// True if it moves a vector to the stack or takes one from there, at a fixed place: with an index it would be an array.
    pub(super) fn spills(&self, code: &Instruction<'_>) -> bool {
        let has = |names: &[&str]| names.iter().any(|name| code.args.contains(name));
        let frame = Instruction {
            op: "movq",
            args: "%rsp, %rbp",
        };
        has(&["%xmm", "%ymm", "%zmm"])
            && (has(&["(%rsp)"]) || has(&["(%rbp)"]) && self.code.contains(&frame))
    }

    fn blocks(&self, tables: &Tables<'_>) -> Vec<Block> {
        let after_jumps = (1..).zip(&self.code).filter(|(_, code)| code.ends_block());
        let mut starts: Vec<usize> = self.labels.values().copied().collect();
        starts.extend(after_jumps.map(|(next, _)| next));
        starts.extend([0, self.code.len()]);
        starts.sort_unstable();
        starts.dedup();
        let block_of = |label: &str| starts.binary_search(self.labels.get(label)?).ok();
        let block = |(at, ends): (usize, &[usize])| {
            let code = ends[0]..ends[1];
            let last = &self.code[code.end - 1];
            let mut next: Vec<usize> = match last.jump() {
                Some(target) if target.starts_with('*') => self
                    .table(code.end - 1)
                    .and_then(|table| tables.get(table))
                    .map_or(&[][..], Vec::as_slice)
                    .iter()
                    .filter_map(|label| block_of(label))
                    .collect(),
                Some(target) => block_of(target).into_iter().collect(),
                None => Vec::new(),
            };
            if !last.is_final() && at + 2 < starts.len() {
                next.push(at + 1);
            }
            Block { code, next }
        };
        starts.windows(2).enumerate().map(block).collect()
    }

    /// The table of the indirect jump at `at`: its base is added to the jump's register just before, and was loaded anywhere.
    fn table(&self, at: usize) -> Option<&'a str> {
        let register = self.code[at].args.strip_prefix('*')?;
        let base = self.code[..at].iter().rev().take(8).find_map(|code| {
            let (base, to) = code.args.split_once(", ")?;
            (code.op == "addq" && to == register).then_some(base)
        })?;
        let load = |code: &Instruction<'a>| {
            let (table, to) = code.args.split_once("(%rip), ")?;
            (to == base && table.starts_with(".LJTI")).then_some(table)
        };
        let (before, after) = self.code.split_at(at);
        (before.iter().rev().find_map(load)).or_else(|| after.iter().find_map(load))
    }
}

impl<'a> Instruction<'a> {
    /// Where it may jump to.
    fn jump(&self) -> Option<&'a str> {
        self.op.starts_with('j').then_some(self.args)
    }

    /// True if what is written below is not what follows.
    fn is_final(&self) -> bool {
        let panics = || {
            self.callee().is_some_and(|callee| {
                // They do not return, and nothing in the text says so.
                [
                    "core::panicking::",
                    "_fail",
                    "_Unwind_Resume",
                    "handle_alloc_error",
                ]
                .iter()
                .any(|name| callee.contains(name))
            })
        };
        self.op.starts_with("jmp") || self.op.starts_with("ret") || self.op == "ud2" || panics()
    }

    fn ends_block(&self) -> bool {
        self.jump().is_some() || self.is_final()
    }

    /// What it calls, demangled; a register as `*%rax`.
    pub(super) fn callee(&self) -> Option<String> {
        if !self.op.starts_with("call") {
            return None;
        }
        let symbol = self.args.split('@').next().unwrap_or(self.args);
        let symbol = symbol.strip_suffix("(%rip)").unwrap_or(symbol);
        match symbol.strip_prefix('*') {
            Some(register) if register.starts_with('%') => Some(symbol.to_owned()),
            other => {
                let symbol = other.unwrap_or(symbol);
                Some(format!("{:#}", rustc_demangle::demangle(symbol)))
            }
        }
    }
}

/// The blocks of each loop: those that reach a jump back to its first block without passing that one.
fn bodies(blocks: &[Block]) -> Vec<Vec<bool>> {
    let mut before = vec![Vec::new(); blocks.len()];
    for (at, block) in blocks.iter().enumerate() {
        block.next.iter().for_each(|&next| before[next].push(at));
    }
    let mut bodies: HashMap<usize, Vec<bool>> = HashMap::new();
    for (from, head) in jumps_back(blocks) {
        let body = bodies
            .entry(head)
            .or_insert_with(|| vec![false; blocks.len()]);
        body[head] = true;
        let mut left = vec![from];
        while let Some(at) = left.pop() {
            if !body[at] {
                body[at] = true;
                left.extend(&before[at]);
            }
        }
    }
    let mut bodies: Vec<_> = bodies.into_iter().collect();
    bodies.sort_unstable_by_key(|(head, _)| *head);
    bodies.into_iter().map(|(_, body)| body).collect()
}

/// The jumps to a block that is still being followed: those that close loops.
fn jumps_back(blocks: &[Block]) -> Vec<(usize, usize)> {
    let mut seen = vec![false; blocks.len()];
    let mut followed = vec![false; blocks.len()];
    let mut found = Vec::new();
    let mut path = vec![(0, 0)];
    while let Some((at, branch)) = path.last_mut() {
        (seen[*at], followed[*at]) = (true, true);
        match blocks.get(*at).and_then(|block| block.next.get(*branch)) {
            Some(&next) => {
                *branch += 1;
                if followed[next] {
                    found.push((*at, next));
                } else if !seen[next] {
                    path.push((next, 0));
                }
            }
            None => {
                followed[*at] = false;
                path.pop();
            }
        }
    }
    found
}

fn size(body: &[bool]) -> usize {
    body.iter().filter(|&&is_in| is_in).count()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The own instructions of each loop, by length.
    fn loops(body: &str) -> Vec<usize> {
        let text = format!(
            "f:\n{body}.Lfunc_end0:\n\t.section\t.rodata\n.LJTI0_0:\n\t.long\t.LBB0_1-.LJTI0_0\n\t.long\t.LBB0_2-.LJTI0_0\n"
        );
        let (functions, tables) = read(&text);
        assert_eq!((functions.len(), &*functions[0].name), (1, "f"));
        functions[0].loops(&tables).iter().map(Vec::len).collect()
    }

    #[test]
    fn an_inner_loop_is_no_part_of_the_outer_ones_own() {
        let found = loops(
            "\tnop\n.LBB0_1:\n\tnop\n\tnop\n.LBB0_2:\n\tnop\n\tjne\t.LBB0_2\n\tnop\n\tjmp\t.LBB0_1\n",
        );
        assert_eq!(found, [4, 2]);
    }

    #[test]
    fn a_block_below_that_jumps_back_into_the_loop_belongs_to_it() {
        let found = loops(
            ".LBB0_1:\n\tje\t.LBB0_9\n.LBB0_2:\n\tjne\t.LBB0_1\n\tretq\n.LBB0_9:\n\tnop\n\tjmp\t.LBB0_2\n",
        );
        assert_eq!(found, [4]);
    }

    #[test]
    fn a_table_leads_back_and_what_cannot_return_does_not() {
        let table = "\tleaq\t.LJTI0_0(%rip), %rdx\n.LBB0_1:\n\tnop\n.LBB0_2:\n\tmovslq\t(%rdx,%rax,4), %rcx\n\taddq\t%rdx, %rcx\n\tjmpq\t*%rcx\n";
        assert_eq!(loops(table), [1, 3]);
        assert_eq!(
            loops(".LBB0_1:\n\tje\t.LBB0_1\n\tud2\n\tjmp\t.LBB0_1\n"),
            [1]
        );
    }
}
