// Runs what plan.rs asks for with the browser's own WebGPU. Knows nothing of what the bytes mean.
//
//   GET /next     the next plan; the answer is held back until there is one
//   POST /done    the bytes read, one buffer after another
//   POST /failed  what went wrong, as text
"use strict";

// The default limits: none is asked for.
async function openDevice() {
    if (!navigator.gpu) throw new Error("no WebGPU: navigator.gpu is absent");
    const adapter = await navigator.gpu.requestAdapter();
    if (!adapter) throw new Error("no WebGPU adapter");
    const device = await adapter.requestDevice();
    device.lost.then(({ reason, message }) => fail(`device lost (${reason}): ${message}`));
    return device;
}

// Pipelines of a plan, made again only when its shaders or bindings are others.
let made = { key: null };

async function pipelines(device, plan) {
    const stages = plan.dispatches.map(({ entry_point: entryPoint, constants }) => ({ entryPoint, constants }));
    const layout = plan.bindings.map(({ number, type }) => ({ number, type }));
    const key = JSON.stringify([plan.wgsl, layout, stages]);
    if (made.key === key) return made;
    const module = device.createShaderModule({ code: plan.wgsl });
    const group = device.createBindGroupLayout({
        entries: layout.map(({ number, type }) => ({
            binding: number,
            visibility: GPUShaderStage.COMPUTE,
            buffer: { type },
        })),
    });
    const pipelineLayout = device.createPipelineLayout({ bindGroupLayouts: [group] });
    const list = await Promise.all(stages.map((stage) =>
        device.createComputePipelineAsync({ layout: pipelineLayout, compute: { module, ...stage } })));
    made = { key, group, list };
    return made;
}

function fromBase64(text) {
    return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}

async function run(device, plan) {
    const { group, list } = await pipelines(device, plan);
    const buffers = new Map();
    for (const { number, type, bytes, contents } of plan.bindings) {
        const use = type === "uniform" ? GPUBufferUsage.UNIFORM : GPUBufferUsage.STORAGE;
        const usage = use | GPUBufferUsage.COPY_SRC | GPUBufferUsage.COPY_DST;
        const buffer = device.createBuffer({ size: bytes, usage });
        device.queue.writeBuffer(buffer, 0, fromBase64(contents));
        buffers.set(number, buffer);
    }
    const entries = [...buffers].map(([number, buffer]) => ({ binding: number, resource: { buffer } }));
    const bound = device.createBindGroup({ layout: group, entries });
    const encoder = device.createCommandEncoder();
    const pass = encoder.beginComputePass();
    pass.setBindGroup(0, bound);
    plan.dispatches.forEach(({ workgroups }, index) => {
        pass.setPipeline(list[index]);
        pass.dispatchWorkgroups(workgroups);
    });
    pass.end();
    const read = plan.read.map((number) => buffers.get(number));
    const size = read.reduce((sum, buffer) => sum + buffer.size, 0);
    const readback = device.createBuffer({ size, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST });
    let at = 0;
    for (const buffer of read) {
        encoder.copyBufferToBuffer(buffer, 0, readback, at, buffer.size);
        at += buffer.size;
    }
    device.queue.submit([encoder.finish()]);
    await readback.mapAsync(GPUMapMode.READ);
    const result = readback.getMappedRange().slice(0);
    for (const buffer of [readback, ...buffers.values()]) buffer.destroy();
    return result;
}

// What WebGPU would only have written to the console becomes an error.
async function checked(device, work) {
    const filters = ["validation", "out-of-memory", "internal"];
    filters.forEach((filter) => device.pushErrorScope(filter));
    const outcome = await work().then((result) => ({ result }), (error) => ({ error }));
    for (const _ of filters) {
        const complaint = await device.popErrorScope();
        if (complaint) throw new Error(complaint.message);
    }
    if (outcome.error) throw outcome.error;
    return outcome.result;
}

function post(path, body) {
    return fetch(path, { method: "POST", body });
}

function fail(error) {
    return post("/failed", String(error));
}

async function serve() {
    let device = null;
    for (;;) {
        const plan = await (await fetch("/next")).json();
        try {
            device ??= await openDevice();
            await post("/done", await checked(device, () => run(device, plan)));
        } catch (error) {
            await fail(error);
        }
    }
}

// The test is over when its server is gone: the last page closes the browser.
serve().catch(() => window.close());
