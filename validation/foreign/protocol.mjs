// How an engine that JavaScript can call answers questions of ours: the protocol of validation/foreign/__init__.py.
import { readSync, writeSync } from "node:fs";

console.log = console.error; // standard output is for answers

function take(count) {
  const bytes = Buffer.alloc(count);
  for (let have = 0; have < count; ) {
    const got = readSync(0, bytes, have, count - have, null);
    if (got === 0) process.exit(0); // nobody asks any more
    have += got;
  }
  return bytes;
}

function give(bytes) {
  for (let sent = 0; sent < bytes.length; ) {
    try {
      sent += writeSync(1, bytes, sent);
    } catch (error) {
      if (error.code !== "EAGAIN") throw error; // the pipe is full
    }
  }
}

/** Answer questions until nobody asks: `answers` has a function for each, of { numbers, arrays }, to arrays.
 * An array is { shape, data: Float64Array }, and so is each of those that a function returns. */
export function serve(answers) {
  for (;;) {
    const length = take(8).readDoubleLE(0);
    const { ask, numbers, shapes } = JSON.parse(take(length).toString());
    const arrays = {};
    for (const [name, shape] of Object.entries(shapes)) {
      const count = shape.reduce((a, b) => a * b, 1);
      const bytes = take(8 * count);
      arrays[name] = { shape, data: new Float64Array(bytes.buffer, bytes.byteOffset, count) };
    }
    let said = { shapes: {} }, rows = {};
    try {
      const answer = answers[ask]({ numbers, arrays });
      said.seconds = answer.seconds;
      rows = answer.arrays;
      for (const name of Object.keys(rows)) said.shapes[name] = rows[name].shape;
    } catch (error) {
      said = { error: String(error), shapes: {} };
      rows = {};
    }
    const head = Buffer.from(JSON.stringify(said)), size = Buffer.alloc(8);
    size.writeDoubleLE(head.length, 0);
    give(Buffer.concat([size, head, ...Object.values(rows).map((one) => Buffer.from(one.data.buffer))]));
  }
}

/** Return an array of a shape for an answer. */
export function zeros(...shape) {
  return { shape, data: new Float64Array(shape.reduce((a, b) => a * b, 1)) };
}

/** Return the seconds of the processor that this process has used. */
export function seconds() {
  const { user, system } = process.cpuUsage();
  return 1e-6 * (user + system);
}
