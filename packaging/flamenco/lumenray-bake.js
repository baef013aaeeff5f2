// SPDX-License-Identifier: GPL-3.0-or-later
//
// Flamenco 3 job type: lux maps by Lumenray. A task for each collection, whose bake goes on where a worker was stopped; then
// a table of all maps with their errors.

const JOB_TYPE = {
  label: "Lumenray Bake",
  description: "Bake illuminance with Lumenray, a task for each collection, and list all maps with their errors",
  settings: [
    { key: "collections", type: "string", default: "", visible: "submission",
      eval: "', '.join(each.name for each in C.scene.collection.children)",
      evalInfo: { showLinkButton: true, description: "All collections of the scene" },
      description: "Collections with commas between them, a task each; none: the collection 'Bake', else all meshes, in one" },
    { key: "density", label: "Lumels per Metre", type: "float", default: 0.0, propargs: { min: 0.0, max: 1000.0 },
      visible: "submission", description: "Density of the maps; 0: as the scene says" },

    { key: "stop", type: "string", default: "as the scene says", visible: "submission",
      choices: ["as the scene says", "error", "error in lx", "samples", "time"],
      description: "What ends a bake; of the numbers below only this one counts" },
    { key: "error", label: "Error [%]", type: "float", default: 2.0, propargs: { min: 0.01, max: 100.0 }, visible: "submission",
      description: "Relative standard error of the maps" },
    { key: "error_lx", label: "Error [lx]", type: "float", default: 5.0, propargs: { min: 0.001 }, visible: "submission",
      description: "Standard error of the maps in lx" },
    { key: "samples", type: "int32", default: 256, propargs: { min: 1, max: 1048576 }, visible: "submission",
      description: "Samples of a lumel" },
    { key: "time", label: "Time [s]", type: "float", default: 600.0, propargs: { min: 0.1 }, visible: "submission",
      description: "Time of a bake, unlike from worker to worker" },
    { key: "accept_errors", type: "bool", default: false, visible: "submission",
      description: "Go on where something of the scene was left out, such as a missing file; else the task fails" },

    { key: "bake_output_root", type: "string", subtype: "dir_path", required: true, visible: "submission",
      description: "Folder below which maps are written, on storage that all workers share" },
    { key: "add_path_components", type: "int32", required: true, default: 0, propargs: { min: 0, max: 32 },
      visible: "submission", description: "Folders of the .blend file's path that are taken over below it" },
    { key: "bake_output_path", type: "string", subtype: "dir_path", editable: false,
      eval: "str(Path(abspath(settings.bake_output_root), last_n_dir_parts(settings.add_path_components), jobname, '{timestamp}'))",
      description: "Where maps are written, a folder for each task" },

    { key: "blendfile", type: "string", required: true, visible: "web", description: "File to bake" },
    { key: "scene", type: "string", required: true, eval: "C.scene.name", visible: "web", description: "Scene to bake" },
  ],
};

function compileJob(job) {
  const settings = job.settings;
  // The web page shows where maps really are.
  settings.bake_output_path = settings.bake_output_path.replace("{timestamp}", formatTimestampLocal(job.created));
  const names = settings.collections.split(",").map((name) => name.trim()).filter((name) => name);
  const parts = (names.length ? names : [""]).map((name, number) => ({ name, folder: folderName(name, number) }));

  const bakes = parts.map((part) => bakeTask(settings, part));
  const table = author.Task("table-of-maps", "blender");
  table.addCommand(blender(settings, [
    "--python-expr", call("collect_bakes"),
    "--", settings.bake_output_path, ...parts.map((part) => `part=${part.folder}`),
  ]));
  bakes.forEach((bake) => table.addDependency(bake));
  for (const task of [...bakes, table]) {
    job.addTask(task);
  }
}

function bakeTask(settings, part) {
  const task = author.Task(`bake-${part.folder}`, "blender");
  const words = [...goal(settings)];
  if (part.name) {
    words.push(`collection=${part.name}`);
  }
  if (settings.density > 0) {
    words.push(`density=${settings.density}`);
  }
  if (settings.accept_errors) {
    words.push("accept=errors");
  }
  task.addCommand(blender(settings, [
    "--python-expr", call("bake"),
    "--", path.join(settings.bake_output_path, part.folder), ...words,
  ]));
  return task;
}

// A name may hold what no folder may, and two may differ in nothing else.
function folderName(name, number) {
  return name ? `${number + 1}_${name.replace(/[\\/:*?"<>|{}\x00-\x1f]/g, "_").replace(/[. ]+$/, "_")}` : "all";
}

function goal(settings) {
  const goals = {
    "error": `error=${settings.error / 100}`,
    "error in lx": `error_lx=${settings.error_lx}`,
    "samples": `samples=${settings.samples}`,
    "time": `time=${settings.time}`,
  };
  return settings.stop in goals ? [goals[settings.stop]] : [];
}

// Blender is run as it is, without a shell, so that nothing has to be quoted.
function blender(settings, args) {
  return author.Command("blender-render", {
    exe: "{blender}",
    exeArgs: "{blenderArgs}",
    argsBefore: ["--python-exit-code", "1"],
    blendfile: settings.blendfile,
    args: ["--scene", settings.scene, ...args],
  });
}

// Python that calls the extension, which reads what follows --. What it does is in Lumenray, and of its version.
function call(verb) {
  return [
    "import importlib, sys",
    "found = [name for name in sys.modules if name.endswith('lumenray.blender_addon')]",
    "if not found:",
    "    raise RuntimeError('Lumenray is not enabled in this Blender: install it for the user that Flamenco Worker runs as')",
    `importlib.import_module(found[0] + '.farm.tasks').${verb}()`,
  ].join("\n");
}
