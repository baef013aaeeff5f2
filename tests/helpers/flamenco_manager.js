// Stands for Flamenco Manager where it compiles a job: node flamenco_manager.js SCRIPT < job.json > tasks.json
// What scripts are given is that of Flamenco 3: print, author, frameChunker, formatTimestampLocal, shellSplit and path.

const fs = require("fs");
const vm = require("vm");
const posix = require("path").posix;

class Task {
  constructor(name, type) {
    Object.assign(this, { name, type, commands: [], dependencies: [] });
  }
  addCommand(command) {
    this.commands.push(command);
  }
  addDependency(task) {
    this.dependencies.push(task);
  }
}

function frameNumbers(range) {
  const pieces = range.split(",").map((piece) => piece.trim().split("-").map(Number));
  return pieces.flatMap(([first, last]) => Array.from({ length: (last ?? first) - first + 1 }, (_, k) => first + k));
}

function mergeFrames(frames) {
  const ranges = [];
  for (const frame of frames) {
    const last = ranges[ranges.length - 1];
    if (last && last[1] === frame - 1) last[1] = frame;
    else ranges.push([frame, frame]);
  }
  return ranges.map(([first, last]) => (first === last ? `${first}` : `${first}-${last}`)).join(",");
}

function frameChunker(range, size) {
  const frames = frameNumbers(range);
  const chunks = [];
  for (let k = 0; k < frames.length; k += size) chunks.push(mergeFrames(frames.slice(k, k + size)));
  return chunks;
}

const context = vm.createContext({
  print: (...words) => console.error(...words),
  author: { Task: (name, type) => new Task(name, type), Command: (name, parameters) => ({ name, parameters }) },
  frameChunker,
  formatTimestampLocal: (date) => date.toISOString().replace("T", "_").replace(/:/g, "").slice(0, 17),
  shellSplit: (text) => text.split(/\s+/).filter((word) => word),
  path: {
    basename: posix.basename,
    dirname: posix.dirname,
    join: posix.join,
    stem: (name) => posix.basename(name, posix.extname(name)),
  },
});

const script = fs.readFileSync(process.argv[2], "utf-8");
vm.runInContext(`${script}\nthis.JOB_TYPE = JOB_TYPE; this.compileJob = compileJob;`, context, { filename: process.argv[2] });
const order = JSON.parse(fs.readFileSync(0, "utf-8"));
const tasks = [];
const job = { created: new Date("2026-01-02T03:04:05Z"), settings: order, addTask: (task) => tasks.push(task) };
let fault = "";
if (order) {
  try {
    context.compileJob(job);
  } catch (error) {
    fault = String(error);
  }
}
const plain = tasks.map((task) => ({ ...task, dependencies: task.dependencies.map((other) => tasks.indexOf(other)) }));
console.log(JSON.stringify({ type: context.JOB_TYPE, tasks: plain, settings: order, fault }));
