// The dispatches of the GPU engine in the browser's WebGPU. /setup describes the buffers of the shaders.

const FILTERS = ["validation", "out-of-memory", "internal"];

// The name of an adapter, if the browser reveals it.
function nameOf({ info }) {
  const words = [info?.description, info?.vendor, info?.architecture, info?.device].filter((word) => word);
  return words.slice(0, 2).join(" ") || "an adapter without a name";
}

export class Gpu {
  // Opens the browser's adapter with the default limits and creates the pipelines.
  static async open(shader) {
    if (!navigator.gpu) throw new Error("this browser has no WebGPU (navigator.gpu is absent)");
    const adapter = await navigator.gpu.requestAdapter();
    if (!adapter) throw new Error("this browser has WebGPU but no adapter for it");
    const device = await adapter.requestDevice();
    const gpu = new Gpu(shader, device, nameOf(adapter));
    await gpu.checked(() => gpu.makePipelines());
    return gpu;
  }

  constructor(shader, device, name) {
    Object.assign(this, { shader, device, name, buffers: {}, sizes: {}, uploadedScene: null });
    this.isLost = device.lost.then(({ message }) => new Error("the device was lost: " + message));
  }

  // Converts WebGPU's errors, which otherwise appear only on the console, to exceptions.
  async checked(work) {
    for (const filter of FILTERS) this.device.pushErrorScope(filter);
    const outcome = await work().then((result) => ({ result }), (error) => ({ error }));
    for (const _ of FILTERS) {
      const scopeError = await this.device.popErrorScope();
      if (scopeError) throw new Error(scopeError.message);
    }
    if (outcome.error) throw outcome.error;
    return outcome.result;
  }

  async makePipelines() {
    const text = await fetch("/shader.wgsl");
    const module = this.device.createShaderModule({ code: await text.text() });
    this.layout = this.device.createBindGroupLayout({
      entries: this.shader.bindings.map(({ type }, binding) => ({ binding, visibility: GPUShaderStage.COMPUTE, buffer: { type } })),
    });
    const layout = this.device.createPipelineLayout({ bindGroupLayouts: [this.layout] });
    const made = this.shader.pipelines.map(async ({ name, entry_point: entryPoint, constants }) =>
      [name, await this.device.createComputePipelineAsync({ layout, compute: { module, entryPoint, constants } })]);
    this.pipelines = Object.fromEntries(await Promise.all(made));
  }

  // Creates buffers of at least these sizes, unless the present ones are large enough. Returns whether it created any.
  allocate(bytes) {
    const missing = Object.keys(bytes).filter((name) => !(this.sizes[name] >= bytes[name]));
    if (missing.length === 0) return false;
    const { COPY_SRC, COPY_DST, MAP_READ, STORAGE, UNIFORM } = GPUBufferUsage;
    for (const name of missing) {
      // The next power of two, so that similar problems share the buffers.
      const size = 2 ** Math.ceil(Math.log2(Math.max(bytes[name], 4096)));
      const usage = STORAGE | COPY_SRC | COPY_DST | (name === "input" ? UNIFORM : 0);
      this.replace(name, { size, usage });
      if (name === "field") this.uploadedScene = null;
      if (name === "answers" || name === "records") this.replace("read " + name, { size, usage: MAP_READ | COPY_DST });
      this.sizes[name] = size;
    }
    const bound = this.shader.bindings.map(({ buffer, type }, binding) => {
      const size = type === "uniform" ? this.shader.uniform_bytes : undefined;
      return { binding, resource: { buffer: this.buffers[buffer], size } };
    });
    this.group = this.device.createBindGroup({ layout: this.layout, entries: bound });
    return true;
  }

  replace(name, descriptor) {
    this.buffers[name]?.destroy();
    this.buffers[name] = this.device.createBuffer({ label: name, ...descriptor });
  }

  // Takes a decision. Returns the words of its answer, the milliseconds from upload to read-back, and whether it allocated or
  // uploaded the field.
  async decide(decision, scene, field) {
    const input = fromBase64(decision.input);
    return this.checked(async () => {
      const begun = performance.now();
      const isCold = this.allocate(decision.bytes);
      const { queue } = this.device;
      const uploads = this.uploadedScene !== scene;
      if (uploads) queue.writeBuffer(this.buffers.field, 0, field);
      this.uploadedScene = scene;
      queue.writeBuffer(this.buffers.input, 0, input);
      const encoder = this.device.createCommandEncoder();
      const pass = encoder.beginComputePass();
      pass.setBindGroup(0, this.group);
      for (const { pipeline, workgroups } of decision.dispatches) {
        pass.setPipeline(this.pipelines[pipeline]);
        pass.dispatchWorkgroups(workgroups);
      }
      pass.end();
      const words = await this.readBack(encoder, "answers", decision.bytes.answers);
      return { words, took: performance.now() - begun, isCold: isCold || uploads };
    });
  }

  // Returns the words of all records of the last decision.
  records(decision) {
    return this.checked(() => this.readBack(this.device.createCommandEncoder(), "records", decision.bytes.records));
  }

  async readBack(encoder, name, bytes) {
    const into = this.buffers["read " + name];
    encoder.copyBufferToBuffer(this.buffers[name], 0, into, 0, bytes);
    this.device.queue.submit([encoder.finish()]);
    await into.mapAsync(GPUMapMode.READ, 0, bytes);
    const words = new Uint32Array(into.getMappedRange(0, bytes).slice(0));
    into.unmap();
    return words;
  }
}

function fromBase64(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
}
