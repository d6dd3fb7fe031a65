// SPDX-License-Identifier: GPL-3.0-or-later
//
// A job type for Flamenco 3 that bakes a mesh's live skin to a point cache: one task for each chunk of frames, and one that
// joins the chunks. Copy this file into the folder "scripts" beside flamenco-manager and refresh the job types in Blender's
// Flamenco panel. Sinew must be installed in every worker's Blender. If the character's drivers need Python, add -y to
// {blenderArgs}.

const JOB_TYPE = {
    label: "Sinew Bake",
    settings: [
        { key: "object", type: "string", required: true, eval: "C.active_object.name if C.active_object else ''",
          evalInfo: { showLinkButton: true, description: "Active object" },
          description: "The mesh to bake, bound by Sinew" },
        { key: "frames", type: "string", required: true, eval: "f'{C.scene.frame_start}-{C.scene.frame_end}'",
          evalInfo: { showLinkButton: true, description: "Scene frame range" },
          description: "First and last frame. Examples: '1-250', '-10..40'" },
        { key: "step", type: "int32", default: 1, propargs: { min: 1 },
          description: "Bake every frame (1), every second (2), ..." },
        { key: "chunk_size", type: "int32", default: 50, propargs: { min: 1 }, visible: "submission",
          description: "Number of frames to bake in one task" },
        { key: "output_folder", type: "string", subtype: "dir_path", required: true, visible: "submission",
          description: "Folder for the cache; all workers must share it" },
        { key: "format", type: "string", default: "pc2", choices: ["pc2", "mdd"],
          description: "Format of the point cache" },
        { key: "points", type: "string", default: "before-armature", choices: ["before-armature", "posed"],
          description: "Points before the Armature modifier, or posed points for other programs" },
        { key: "blendfile", type: "string", required: true, visible: "web",
          description: "Path of the Blend file to bake" },
    ],
};

function compileJob(job) {
    const settings = job.settings;
    const chunks = chunkCount(settings);
    print("Sinew: " + settings.object + " in " + chunks + " chunks");

    const mergeTask = blenderTask("merge", settings, ["merge", settings.output_folder, "--object=" + settings.object]);
    for (let number = 1; number <= chunks; number++) {
        const task = blenderTask("bake-" + number + "-of-" + chunks, settings, [
            "bake", settings.blendfile,
            "--object=" + settings.object,
            "--frames=" + blenderFrames(settings.frames),
            "--step=" + settings.step,
            "--chunk=" + number + "/" + chunks,
            "--format=" + settings.format,
            "--points=" + settings.points,
            "--output=" + settings.output_folder,
        ]);
        mergeTask.addDependency(task);
        job.addTask(task);
    }
    job.addTask(mergeTask);
}

// A task that runs one command of Sinew. Values follow their option with =, because a name may begin with -. All versions of Flamenco can start Blender with the command blender-render. It opens
// the file, and Sinew does not open a file again that is already open.
function blenderTask(name, settings, sinewArgs) {
    const task = author.Task(name, "blender");
    task.addCommand(author.Command("blender-render", {
        exe: "{blender}",
        exeArgs: "{blenderArgs}",
        argsBefore: [],
        blendfile: settings.blendfile,
        args: ["--command", "sinew"].concat(sinewArgs),
    }));
    return task;
}

// Returns first and last frame. Flamenco's frameChunker does not accept negative frames.
function frameRange(frames) {
    const match = /^\s*(-?\d+)\s*(?:(?:-|\.\.)\s*(-?\d+))?\s*$/.exec(frames);
    if (!match) {
        throw "frames \"" + frames + "\" is not a range: write first-last, such as 1-250";
    }
    const first = parseInt(match[1], 10);
    const last = match[2] === undefined ? first : parseInt(match[2], 10);
    if (last < first) {
        throw "frames \"" + frames + "\": the last frame is before the first";
    }
    return [first, last];
}

function blenderFrames(frames) {
    return frameRange(frames).join("..");
}

function chunkCount(settings) {
    if (!(settings.step >= 1) || !(settings.chunk_size >= 1)) {
        throw "step and chunk_size must be 1 or more";
    }
    const range = frameRange(settings.frames);
    const count = Math.floor((range[1] - range[0]) / settings.step) + 1;
    return Math.ceil(count / settings.chunk_size);
}
