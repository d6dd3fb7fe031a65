// SPDX-License-Identifier: GPL-3.0-or-later
//
// A stub of Flamenco's job compiler, with the globals and the checks of its author.go, js_globals.go and js_path.go.
// usage: node flamenco_stub.js JOB_TYPE.js SETTINGS.json      (prints the job type's settings and the job's tasks as JSON)

const fs = require("fs");
const path = require("path").posix;
const vm = require("vm");

class Task {
    constructor(name, type) {
        this.name = name.trim();
        this.type = type.trim();
        if (!this.name || !this.type) throw new Error("author.Task(name, type): both are required");
        this.commands = [];
        this.dependencies = [];
    }
    addCommand(command) { this.commands.push(command); }
    addDependency(task) {
        if (!(task instanceof Task)) throw new Error("addDependency() takes a task");
        this.dependencies.push(task);
    }
}

class Job {
    constructor(settings) {
        this.name = "stub";
        this.settings = settings;
        this.created = new Date(0);
        this.tasks = [];
    }
    addTask(task) {
        // a copy, as in Flamenco: later changes of the task are lost
        this.tasks.push({ ...task, commands: [...task.commands], dependencies: task.dependencies.map((other) => other.name) });
    }
}

const [script, settingsFile] = process.argv.slice(2);
const context = vm.createContext({
    print: (...words) => console.error(...words),
    alert: (...words) => console.error(...words),
    author: {
        Task: (name, type) => new Task(name, type),
        Command: (name, parameters) => ({ name, parameters }),
    },
    path: { basename: path.basename, dirname: path.dirname, join: path.join, stem: (name) => path.parse(name).name },
});
vm.runInContext(fs.readFileSync(script, "utf8") + "\nthis.JOB_TYPE = JOB_TYPE; this.compileJob = compileJob;", context);

const given = JSON.parse(fs.readFileSync(settingsFile, "utf8"));
const settings = {};
for (const setting of context.JOB_TYPE.settings) {
    if (setting.key in given) settings[setting.key] = given[setting.key];
    else if (setting.default !== undefined) settings[setting.key] = setting.default;
    else if (setting.required) throw new Error("setting " + setting.key + " is required");
}
const job = new Job(settings);
context.compileJob(job);
console.log(JSON.stringify({
    label: context.JOB_TYPE.label,
    settings: context.JOB_TYPE.settings,
    tasks: job.tasks,
}));
