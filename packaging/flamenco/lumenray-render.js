// SPDX-License-Identifier: GPL-3.0-or-later
//
// Flamenco 3 job type: an animation by Lumenray. Frames in chunks, each checked by the worker that rendered them; then a
// table of all frames with their errors, and on request a video.

const JOB_TYPE = {
  label: "Lumenray Animation",
  description: "Render frames with Lumenray, check each of them and list their errors",
  settings: [
    { key: "frames", type: "string", required: true,
      eval: "f'{C.scene.frame_start}-{C.scene.frame_end}'",
      evalInfo: { showLinkButton: true, description: "Scene frame range" },
      description: "Frames to render. Examples: '47', '1-30', '3, 5-10, 47-327'" },
    { key: "chunk_size", type: "int32", default: 1, propargs: { min: 1 }, visible: "submission",
      description: "Frames of a task; more of them share what a worker prepares" },

    { key: "stop", type: "string", default: "as the scene says", visible: "submission",
      choices: ["as the scene says", "error", "samples", "time"],
      description: "What ends a frame; of the numbers below only this one counts" },
    { key: "error", label: "Error [%]", type: "float", default: 2.0, propargs: { min: 0.01, max: 100.0 }, visible: "submission",
      description: "Relative standard error of the pixels" },
    { key: "samples", type: "int32", default: 64, propargs: { min: 2, max: 1048576 }, visible: "submission",
      description: "Samples of a pixel on the mean" },
    { key: "time", label: "Time [s]", type: "float", default: 60.0, propargs: { min: 0.1 }, visible: "submission",
      description: "Time of a frame, unlike from worker to worker" },
    { key: "accept_errors", type: "bool", default: false, visible: "submission",
      description: "Go on where something of the scene was left out, such as a missing file; else the task fails" },
    { key: "video", type: "bool", default: false, visible: "submission",
      description: "Also make a video of the frames (needs FFmpeg on a worker, and PNG or JPEG frames)" },

    { key: "render_output_root", type: "string", subtype: "dir_path", required: true, visible: "submission",
      description: "Folder below which frames are written, on storage that all workers share" },
    { key: "add_path_components", type: "int32", required: true, default: 0, propargs: { min: 0, max: 32 },
      visible: "submission", description: "Folders of the .blend file's path that are taken over below it" },
    { key: "render_output_path", type: "string", subtype: "file_path", editable: false,
      eval: "str(Path(abspath(settings.render_output_root), last_n_dir_parts(settings.add_path_components), jobname, '{timestamp}', '######'))",
      description: "Where frames are written" },

    { key: "blendfile", type: "string", required: true, visible: "web", description: "File to render" },
    { key: "scene", type: "string", required: true, eval: "C.scene.name", visible: "web", description: "Scene to render" },
    { key: "format", type: "string", required: true, eval: "C.scene.render.image_settings.file_format", visible: "web" },
    { key: "image_file_extension", type: "string", required: true, eval: "C.scene.render.file_extension", visible: "hidden" },
    { key: "fps", type: "float", eval: "C.scene.render.fps / C.scene.render.fps_base", visible: "hidden" },
  ],
};

// What Blender writes as one file, which no two workers can.
const VIDEO_FORMATS = ["FFMPEG", "AVI_RAW", "AVI_JPEG"];

// Frames that FFmpeg reads.
const FORMATS_FOR_VIDEO = ["PNG", "JPEG"];

function compileJob(job) {
  const settings = job.settings;
  if (VIDEO_FORMATS.includes(settings.format)) {
    throw `frames are pictures, and not ${settings.format}: choose an image format in the scene's output`;
  }
  if (settings.video && !FORMATS_FOR_VIDEO.includes(settings.format)) {
    throw `a video is made of ${FORMATS_FOR_VIDEO.join(" or ")} frames, and not of ${settings.format}`;
  }
  // The web page shows where frames really are.
  settings.render_output_path = settings.render_output_path.replace("{timestamp}", formatTimestampLocal(job.created));
  const folder = path.dirname(settings.render_output_path);

  const renders = frameChunker(settings.frames, settings.chunk_size).map((chunk) => renderTask(settings, folder, chunk));
  const table = tableTask(settings, folder, renders);
  const tasks = [...renders, table];
  if (settings.video) {
    tasks.push(videoTask(settings, folder, table));
  }
  for (const task of tasks) {
    job.addTask(task);
  }
}

function renderTask(settings, folder, chunk) {
  const frames = blenderFrames(chunk);
  const task = author.Task(`render-${chunk}`, "blender");
  task.addCommand(blender(settings, [
    ...output(settings),
    "--python-expr", call("prepare"),
    "--render-frame", frames,
    "--python-expr", call("check"),
    "--", folder, `frames=${frames}`, ...goal(settings), ...accepting(settings),
  ]));
  return task;
}

function tableTask(settings, folder, renders) {
  const task = author.Task("table-of-frames", "blender");
  const frames = renders.length ? blenderFrames(frameChunker(settings.frames, 1 << 30).join(",")) : "";
  task.addCommand(blender(settings, [
    ...output(settings),
    "--python-expr", call("collect_frames"),
    "--", folder, `frames=${frames}`,
  ]));
  renders.forEach((render) => task.addDependency(render));
  return task;
}

function videoTask(settings, folder, table) {
  const name = path.stem(settings.blendfile).replace(".flamenco", "");
  const task = author.Task("video", "ffmpeg");
  task.addCommand(author.Command("frames-to-video", {
    exe: "ffmpeg",
    fps: settings.fps,
    inputGlob: path.join(folder, `*${settings.image_file_extension}`),
    outputFile: path.join(folder, `${name}.mp4`),
    args: [
      "-c:v", "h264", "-crf", "20", "-g", "18", "-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p",
      "-r", `${settings.fps}`, "-y",
    ],
  }));
  task.addDependency(table);
  return task;
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

function output(settings) {
  return ["--engine", "LUMENRAY", "--render-output", settings.render_output_path, "--render-format", settings.format];
}

function goal(settings) {
  const goals = { error: `error=${settings.error / 100}`, samples: `samples=${settings.samples}`, time: `time=${settings.time}` };
  return settings.stop in goals ? [goals[settings.stop]] : [];
}

function accepting(settings) {
  return settings.accept_errors ? ["accept=errors"] : [];
}

function blenderFrames(chunk) {
  return chunk.replace(/\s/g, "").replace(/-/g, "..");
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
