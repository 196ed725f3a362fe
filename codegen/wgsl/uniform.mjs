// Makes branches around barriers uniform. SPIR-V has the rule that all threads of a group reach a
// barrier together; WGSL wants to see that, and takes every value for different that came through
// memory that the kernel writes. Where a barrier depends on such a value, the group takes the one of
// its first thread.

const DIFFERENT_INPUTS = /@builtin\((?:local_invocation_index|local_invocation_id|global_invocation_id)\) (\w+):/g;
const BARRIER = /^\s*(?:workgroup|storage)Barrier\(\);$/;

/**
 * @typedef {{kind: "function" | "if" | "else" | "loop" | "continuing" | "switch" | "case",
 *   first: number, last: number, outer: Block | null}} Block lines of a block, its first and last
 *   ones included
 * @typedef {{line: number, block: Block, target: Block, condition: boolean}} Jump
 */

/** @param {string} text @returns {string[]} */
const namesIn = (text) => text.match(/[A-Za-z_]\w*/g) ?? [];

/**
 * The blocks of a function as naga writes it: one statement a line.
 * @param {string[]} lines
 * @param {number} begin line of its head
 */
function blocksOf(lines, begin) {
  /** @type {Block[]} innermost block of each line */
  const blockOf = [];
  /** @type {Block | null} */
  let block = null;
  for (let i = begin; i < lines.length; ++i) {
    const text = lines[i].trim();
    if (text.startsWith("}") && block) {
      block.last = i;
      if (!text.endsWith("{")) blockOf[i] = block;
      block = block.outer;
      if (!block) return { blockOf, end: i };
    }
    if (text.endsWith("{")) {
      const word = /^(?:\} )?(fn|if|else|loop|continuing|switch|default|case)\b/.exec(text)?.[1];
      if (!word) throw new Error(`WGSL has a block of an unknown kind: ${text}`);
      const kind = word === "fn" ? "function" : word === "default" ? "case" : word;
      block = { kind: /** @type {Block["kind"]} */ (kind), first: i, last: i, outer: block };
    }
    if (blockOf[i] === undefined && block) blockOf[i] = block;
  }
  throw new Error("WGSL has a function without an end");
}

/** @param {Block | null} block @param {Block["kind"][]} kinds */
function enclosing(block, kinds) {
  while (block && !kinds.includes(block.kind)) block = block.outer;
  if (!block) throw new Error("WGSL has a jump without a target");
  return block;
}

/** @param {Block} block from it to its outermost one @returns {Block[]} */
function chainOf(block) {
  const chain = [];
  for (let at = /** @type {Block | null} */ (block); at; at = at.outer) chain.push(at);
  return chain;
}

/**
 * The line that has the condition of a block.
 * @param {Block} block
 * @param {string[]} lines
 */
function headOf(block, lines) {
  if (block.kind !== "else") return block.first;
  const indent = /^ */.exec(lines[block.first])?.[0].length ?? 0;
  let i = block.first - 1;
  while (!(lines[i].startsWith("if", indent) && /^ *if/.test(lines[i]))) --i;
  return i;
}

/**
 * @param {string} wgsl a module of naga, whose inputs are parameters of `function_`
 * @returns {string} the module, in which WebGPU sees that barriers are reached by whole groups
 */
export function agreeOnBranches(wgsl) {
  const lines = wgsl.split("\n");
  const begin = lines.findIndex((line) => line.startsWith("fn function_("));
  const entry = lines.findIndex((line) => /^@compute\b/.test(line)) + 1;
  if (begin < 0 || entry === 0 || !lines.some((line) => BARRIER.test(line))) return wgsl;
  const { blockOf, end } = blocksOf(lines, begin);
  const barriers = lines.flatMap((line, i) => (BARRIER.test(line) ? [i] : []));
  if (barriers.some((i) => i < begin || i > end)) throw new Error("WGSL has a barrier in a function of naga's");
  const hasBarrier = (/** @type {number} */ first, /** @type {number} */ last) =>
    barriers.some((i) => i > first && i < last);

  /** @type {Jump[]} */
  const jumps = [];
  for (let i = begin; i < end; ++i) {
    const word = /^\s*(break if|break|continue|return)\b/.exec(lines[i])?.[1];
    if (!word) continue;
    const kinds = { return: ["function"], break: ["loop", "switch"] }[word] ?? ["loop"];
    const target = enclosing(blockOf[i], /** @type {Block["kind"][]} */ (kinds));
    jumps.push({ line: i, block: blockOf[i], target, condition: word === "break if" });
  }
  /** Blocks between a jump and its target. @param {Jump} jump */
  const left = (jump) => chainOf(jump.block).slice(0, chainOf(jump.block).indexOf(jump.target));
  // A thread that jumps does not reach the barriers behind, and in a loop all of them are behind.
  const misses = (/** @type {Jump} */ { line, block, target }) =>
    [target, ...chainOf(block)].some(({ kind, first, last }) => kind === "loop" && first >= target.first && hasBarrier(first, last)) ||
    hasBarrier(line, target.last);

  /** @type {Set<number>} lines of the conditions that decide whether a barrier is reached */
  const deciding = new Set();
  const decides = (/** @type {Block[]} */ blocks) => {
    for (const block of blocks)
      if (["if", "else", "switch"].includes(block.kind)) deciding.add(headOf(block, lines));
  };
  for (const i of barriers) decides(chainOf(blockOf[i]));
  for (const jump of jumps) {
    if (!misses(jump)) continue;
    decides(left(jump));
    if (jump.condition) deciding.add(jump.line);
  }

  // Names of what may differ within a group.
  const different = new Set(
    [...wgsl.matchAll(/^var<(?:private|workgroup|storage, read_write)> (\w+):/gm)].map(([, name]) => name),
  );
  const call = lines.find((line) => /^    function_\(/.test(line)) ?? "";
  const given = namesIn(call).slice(1);
  const taken = [...lines[begin].matchAll(/(\w+): /g)].map(([, name]) => name);
  for (const [, name] of lines[entry].matchAll(DIFFERENT_INPUTS)) different.add(taken[given.indexOf(name)]);
  const differs = (/** @type {string} */ text) => namesIn(text).some((name) => different.has(name));
  /** @param {number} line of a condition @returns {boolean} threads may go different ways there */
  const parts = (line) => !deciding.has(line) && differs(lines[line]);
  for (let before = -1; before !== different.size; ) {
    before = different.size;
    const splits = (/** @type {Block} */ { kind, ...block }) =>
      ["if", "else", "switch"].includes(kind) && parts(headOf({ kind, ...block }, lines));
    const dividing = jumps.filter((jump) => left(jump).some(splits) || (jump.condition && parts(jump.line)));
    // Some threads have left before the line; in a loop, maybe in an earlier round.
    const isDivided = (/** @type {Block} */ block, /** @type {number} */ line) =>
      dividing.some(({ target, line: jump }) => target === block && (block.kind === "loop" || jump < line));
    for (let i = begin + 1; i < end; ++i) {
      const assignment = /^\s*(?:let |var )?(\w+)(?:: [^=]+)? = (.*);$/.exec(lines[i]);
      if (!assignment || different.has(assignment[1])) continue;
      const chain = chainOf(blockOf[i]);
      const isLet = /^\s*let /.test(lines[i]);
      if (differs(assignment[2]) || (!isLet && chain.some((block) => splits(block) || isDivided(block, i))))
        different.add(assignment[1]);
    }
  }

  const unseen = [...deciding].filter((line) => differs(lines[line]));
  if (unseen.length === 0) return wgsl;
  for (const line of unseen) {
    lines[line] = lines[line].replace(/^(\s*)(if|break if) (.*?)( \{|;)$/, "$1$2 agreed($3)$4");
    if (!lines[line].includes("agreed(")) throw new Error(`WGSL has a barrier that depends on: ${lines[line].trim()}`);
  }
  const index = /@builtin\(local_invocation_index\) (\w+)/.exec(lines[entry])?.[1];
  if (!index)
    lines[entry] = lines[entry].replace(/\) \{$/, `${/\(\) \{$/.test(lines[entry]) ? "" : ", "}@builtin(local_invocation_index) agreed_index: u32) {`);
  lines[entry] += `\n    agreed_first = ${index ?? "agreed_index"} == 0u;`;
  lines[begin] = [
    "var<private> agreed_first: bool;",
    "var<workgroup> agreed_value: bool;",
    "",
    "fn agreed(value: bool) -> bool {",
    "    if agreed_first {",
    "        agreed_value = value;",
    "    }",
    "    return workgroupUniformLoad(&agreed_value);",
    "}",
    "",
    lines[begin],
  ].join("\n");
  return lines.join("\n");
}
