// Barriers in branches that WGSL takes for divergent: node uniform_test.mjs, beside uniform.mjs
import assert from "node:assert";
import { agreeOnBranches } from "./uniform.mjs";

/** A kernel in the form of naga's, with these statements. */
const kernel = (body, parameters = "group: vec3<u32>, lane: u32") => `@group(0) @binding(0)
var<storage, read_write> written: array<u32>;
@group(0) @binding(1)
var<storage> given: array<u32>;
var<workgroup> shared_word: u32;

fn function_(${parameters === "" ? "" : "group_in: vec3<u32>, lane_in: u32"}) {
    var phi_1_: u32;

${parameters === "" ? "" : "    let group = group_in;\n    let lane = lane_in;\n"}${body.replace(/^/gm, "    ")}
    return;
}

@compute @workgroup_size(64, 1, 1)
fn some(${parameters === "" ? "" : "@builtin(workgroup_id) group: vec3<u32>, @builtin(local_invocation_index) lane: u32"}) {
    function_(${parameters === "" ? "" : "group, lane"});
}
`;
const agreements = (text) => agreeOnBranches(text).split("\n").flatMap((line) => (/(if|break if) agreed\(/.test(line) ? [line.trim()] : []));
const same = (text) => assert.equal(agreeOnBranches(text), text);

// Conditions that WGSL sees to be uniform: constants, the group, buffers that are only read.
same(kernel("if (group.x < 3u) {\n    workgroupBarrier();\n}"));
same(kernel("let _e1 = given[group.x];\nif (_e1 < 3u) {\n    workgroupBarrier();\n}"));
// Threads that part where there is no barrier, or behind all of them.
same(kernel("if (lane == 0u) {\n    written[0] = 1u;\n}\nworkgroupBarrier();\nif (lane == 1u) {\n    return;\n}"));

// Values that came through memory: a branch, an early return, a loop.
const branch = kernel("let _e1 = shared_word;\nif (_e1 < 3u) {\n    workgroupBarrier();\n}");
assert.deepEqual(agreements(branch), ["if agreed((_e1 < 3u)) {"]);
const early = kernel("let _e1 = written[group.x];\nif (_e1 < 3u) {\n    return;\n}\nworkgroupBarrier();");
assert.deepEqual(agreements(early), ["if agreed((_e1 < 3u)) {"]);
const loop = kernel(`phi_1_ = 0u;
loop {
    let _e1 = phi_1_;
    let _e2 = shared_word;
    if (_e1 < _e2) {
        workgroupBarrier();
        continue;
    } else {
        break;
    }
    continuing {
        phi_1_ = (_e1 + 1u);
    }
}`);
assert.deepEqual(agreements(loop), ["if agreed((_e1 < _e2)) {"]);
// A value that threads gave to a variable where they had parted.
const variable = kernel("phi_1_ = 0u;\nif (lane < 3u) {\n    phi_1_ = 1u;\n}\nlet _e1 = phi_1_;\nif (_e1 == 0u) {\n    workgroupBarrier();\n}");
assert.deepEqual(agreements(variable), ["if agreed((_e1 == 0u)) {"]);
const last = kernel("loop {\n    workgroupBarrier();\n    continuing {\n        let _e1 = shared_word;\n        break if (_e1 == 0u);\n    }\n}");
assert.deepEqual(agreements(last), ["break if agreed((_e1 == 0u));"]);
// The first thread is told by its index, also where the kernel has no use for one.
assert.match(agreeOnBranches(branch), /\n {4}agreed_first = lane == 0u;\n/);
const bare = kernel("let _e1 = shared_word;\nif (_e1 < 3u) {\n    workgroupBarrier();\n}", "");
assert.match(agreeOnBranches(bare), /fn some\(@builtin\(local_invocation_index\) agreed_index: u32\) \{\n {4}agreed_first = agreed_index == 0u;/);

assert.throws(() => agreeOnBranches(kernel("while (lane < 3u) {\n    workgroupBarrier();\n}")), /unknown kind/);
assert.throws(
  () => agreeOnBranches(kernel("let _e1 = shared_word;\nswitch _e1 {\n    case 1: {\n        workgroupBarrier();\n    }\n}")),
  /depends on: switch/,
);
console.log("branches around barriers are uniform");
