"""WGSL, compiled and run by a browser's WebGPU where there is one, agrees with evaluation."""

import json
import shutil
import subprocess
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from queue import Empty, Queue
from threading import Thread
from typing import Any

import numpy as np
import pytest

from motorcade.ga.codegen.targets import wgsl
from tests.ga.codegen.targets.conftest import Case, scripts

CHROMIUM = (
    shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
)
ROWS = 256
# WGSL allows sin and cos an error of 2^-11 between -π and π, and atan, asin and acos more.
DRIVERS = 2e-3
PAGE = """<script>
async function run(device, one) {
  const module = device.createShaderModule({ code: one.code });
  const told = await module.getCompilationInfo();
  if (told.messages.length) return told.messages.map((m) => m.lineNum + ": " + m.message);
  const { STORAGE, COPY_DST, COPY_SRC, MAP_READ } = GPUBufferUsage;
  const held = (size, usage) => device.createBuffer({ size, usage });
  const bytes = one.width * one.rows * 4;
  const given = held(one.given.length * 4, STORAGE | COPY_DST);
  const made = held(bytes, STORAGE | COPY_SRC), read = held(bytes, MAP_READ | COPY_DST);
  device.queue.writeBuffer(given, 0, new Float32Array(one.given));
  const pipeline = await device.createComputePipelineAsync(
    { layout: "auto", compute: { module, entryPoint: "main" } });
  const entries = [given, made].map((buffer, binding) => ({ binding, resource: { buffer } }));
  const encoder = device.createCommandEncoder(), pass = encoder.beginComputePass();
  pass.setPipeline(pipeline);
  pass.setBindGroup(0, device.createBindGroup({ layout: pipeline.getBindGroupLayout(0), entries }));
  pass.dispatchWorkgroups(one.rows);
  pass.end();
  encoder.copyBufferToBuffer(made, 0, read, 0, bytes);
  device.queue.submit([encoder.finish()]);
  await read.mapAsync(GPUMapMode.READ);
  return Array.from(new Float32Array(read.getMappedRange()));
}
(async () => {
  const adapter = navigator.gpu && await navigator.gpu.requestAdapter(), all = {};
  const device = adapter && await adapter.requestDevice();
  for (const [name, one] of device ? Object.entries(SCRIPTS) : []) {
    try { all[name] = await run(device, one); } catch (error) { all[name] = [String(error)]; }
  }
  fetch("/", { method: "POST", body: JSON.stringify(all) });
})();
</script>"""


def shader(case: Case) -> str:
    """The function, and an entry point that calls it for one row."""
    (function,) = wgsl.write(case.program, None).values()
    outputs = [o for o in case.program.tape.outputs if o.width]
    given, width = len(case.inputs), sum(o.width for o in outputs)
    lines = [
        "@group(0) @binding(0) var<storage, read> given: array<f32>;",
        "@group(0) @binding(1) var<storage, read_write> made: array<f32>;",
        "@compute @workgroup_size(1) fn main(@builtin(global_invocation_id) id: vec3<u32>) {",
        *(f"var o{k}: array<f32, {o.width}>;" for k, o in enumerate(outputs)),
    ]
    arguments = [f"given[id.x * {given}u + {i}u]" for i in range(given)]
    arguments += [f"&o{k}" for k in range(len(outputs))]
    lines.append(f"{case.program.name}({', '.join(arguments)});")
    places = [f"o{k}[{i}]" for k, o in enumerate(outputs) for i in range(o.width)]
    lines += [f"made[id.x * {width}u + {i}u] = {place};" for i, place in enumerate(places)]
    return "\n".join([function, *lines, "}"])


def browsed(page: str, folder: Path) -> dict[str, Any]:
    """What a page in the browser posts back; skips where it has no WebGPU."""
    posted: Queue[str] = Queue()

    class Handler(BaseHTTPRequestHandler):
        def do_GET(self) -> None:
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(page.encode())

        def do_POST(self) -> None:
            posted.put(self.rfile.read(int(self.headers["Content-Length"])).decode())
            self.send_response(204)
            self.end_headers()

        def log_message(self, *told: Any) -> None:
            """Nothing is told."""

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        Thread(target=server.serve_forever, daemon=True).start()
        flags = ["--headless", "--no-sandbox", f"--user-data-dir={folder / 'profile'}"]
        flags += ["--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader"]
        command = [str(CHROMIUM), *flags, f"http://127.0.0.1:{server.server_port}/"]
        browser = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        try:
            answer = json.loads(posted.get(timeout=120))
        except Empty:
            pytest.skip("no answer from this browser")
        finally:
            browser.terminate()
            browser.wait()
            server.shutdown()
    if not answer:
        pytest.skip("no WebGPU in this browser")
    made: dict[str, Any] = answer
    return made


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="no chromium here")
def test_a_browser_computes_what_evaluation_says(cases: Any, tmp_path: Path) -> None:
    made = {name: cases(name, "float32") for name in scripts()}
    told = {
        name: {
            "code": shader(case),
            "given": np.stack([v[:ROWS] for v in case.inputs.values()], axis=1).ravel().tolist(),
            "rows": ROWS,
            "width": sum(o.width for o in case.program.tape.outputs),
        }
        for name, case in made.items()
    }
    answers = browsed(PAGE.replace("SCRIPTS", json.dumps(told)), tmp_path)
    for name, case in made.items():
        assert all(isinstance(value, float | int) for value in answers[name]), answers[name][:5]
        rows = np.array(answers[name], dtype=np.float64).reshape(ROWS, -1).T
        head = Case(
            case.program,
            {key: value[:ROWS] for key, value in case.inputs.items()},
            {key: {b: v[:ROWS] for b, v in x.items()} for key, x in case.expected.items()},
        )
        head.checked(head.by_place(rows), DRIVERS)
