// Smooths poses in JavaScript, by the C header as WebAssembly. Build it once, here with Zig's
// compiler (`pip install ziglang`), which holds all that it needs:
//
//     printf '#include "motorcade/smooth.h"\n' > smooth.c
//     python -m ziglang cc -target wasm32-wasi -mexec-model=reactor -O2 -I"$INCLUDE" \
//         '-DMOTORCADE_API=__attribute__((visibility("default")))' \
//         -Wl,--strip-all,--export-dynamic,--export=malloc,--export=free smooth.c -o smooth.wasm
//
// Then, with Node or in a browser (where `fetch` takes the place of `readFileSync`):
//
//     node smooth.mjs smooth.wasm rts < noisy.csv > smoothed.csv
//
// Rows hold time_ns,x,y,z,qw,qx,qy,qz, as EuRoC's. The method is rts, velocity or one_euro.

import { readFileSync } from "node:fs";

const METHODS = ["rts", "velocity", "one_euro"];
const [file, method] = process.argv.slice(2);
if (!METHODS.includes(method)) {
    console.error("usage: node smooth.mjs smooth.wasm rts|velocity|one_euro < poses.csv");
    process.exit(2);
}

// Nothing of WASI is called; the header neither reads nor writes.
const wasi = new Proxy({}, { get: (_, name) => () => { throw new Error(`${name} was called`); } });
const { instance } = await WebAssembly.instantiate(readFileSync(file), {
    wasi_snapshot_preview1: wasi,
});
const c = instance.exports;
c._initialize?.();

// Views are made anew at each use: memory moves where it grows.
const doubles = (at, count) => new Float64Array(c.memory.buffer, at, count);
const stamps = (at, count) => new BigInt64Array(c.memory.buffer, at, count);
const text = (at) => {
    const bytes = new Uint8Array(c.memory.buffer, at);
    return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
};
const check = (status) => {
    if (status !== 0) throw new Error(text(c.motorcade_message(status)));
};

const rows = readFileSync(0, "utf8").split("\n").filter((row) => row && !row.startsWith("#"));
const count = rows.length;
const motors = c.malloc(64 * count), times = c.malloc(8 * count), pose = c.malloc(56);
rows.forEach((row, k) => {
    const [time, ...numbers] = row.split(",");
    stamps(times, count)[k] = BigInt(time);
    doubles(pose, 7).set(numbers.map(Number));
    c.motorcade_motor_of_pose(pose, pose + 24, motors + 64 * k);
});

// A model: order (an int, padded), then densities and deviations in rad and m.
const model = c.malloc(40);
c.motorcade_constant_velocity(model);
if (method === "rts") {
    const work = c.malloc(c.motorcade_kalman_size() * c.motorcade_rts_work(count));
    check(c.motorcade_rts(model, motors, times, count, 0, motors, 0, work));
} else {
    const isKalman = method === "velocity";
    const filter = c.malloc(isKalman ? c.motorcade_kalman_size() : c.motorcade_one_euro_size());
    check(isKalman
        ? c.motorcade_kalman_start(filter, model)
        : c.motorcade_one_euro_start(filter, 1, 100, 100, 1));
    const update = isKalman ? c.motorcade_kalman_update : c.motorcade_one_euro_update;
    for (let k = 0; k < count; ++k) {
        const motor = motors + 64 * k;
        check(update(filter, motor, stamps(times, count)[k], motor));
    }
}

const made = rows.map((_, k) => {
    c.motorcade_pose_of_motor(motors + 64 * k, pose, pose + 24);
    return [stamps(times, count)[k], ...doubles(pose, 7)].join(",") + "\n";
});
process.stdout.write(made.join(""));
