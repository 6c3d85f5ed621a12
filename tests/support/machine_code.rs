//! Counts of the machine code of AMD's compiler.

use std::collections::HashMap;

/// Cycles that the vector unit needs for an instruction of 32 lanes: a full product and a root or quotient take four.
fn cycles(mnemonic: &str) -> u64 {
    const SLOW: [&str; 8] = [
        "v_mul_lo_u32",
        "v_mul_lo_i32",
        "v_mul_hi_",
        "v_mad_u64_",
        "v_mad_i64_",
        "v_sqrt_",
        "v_rcp_",
        "v_rsq_",
    ];
    match mnemonic {
        slow if SLOW.iter().any(|start| slow.starts_with(start)) => 4,
        vector if vector.starts_with("v_") => 1,
        _ => 0,
    }
}

/// Cycles of the vector unit in the largest loop: one pass, inner loops once. A loop reaches from a label to the last branch
/// back to it.
pub fn largest_loop_cycles(code: &str) -> u64 {
    let lines: Vec<&str> = code.lines().map(str::trim).collect();
    let labels: HashMap<&str, usize> = (0..)
        .zip(&lines)
        .filter_map(|(index, line)| Some((line.strip_suffix(':')?, index)))
        .collect();
    let mut largest = 0;
    for (end, line) in lines.iter().enumerate() {
        let mut words = line.split_whitespace();
        let is_branch = words.next().is_some_and(|word| word.contains("branch"));
        let target = words.next().and_then(|label| labels.get(label));
        if let Some(&start) = target.filter(|&&start| is_branch && start < end) {
            let mnemonics =
                lines[start..end].iter().filter_map(|line| line.split_whitespace().next());
            largest = largest.max(mnemonics.map(cycles).sum());
        }
    }
    largest
}
