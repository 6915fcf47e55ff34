"""A material of `diffract export` on a device of wgpu: its textures, its WGSL function, and a compute shader that calls it."""

import struct
from pathlib import Path

import numpy as np
import wgpu

# Calls the function for one question in each thread. The function takes its textures as parameters, so that any bindings do.
MAIN = """
struct Question { light: vec4<f32>, viewer: vec4<f32>, footprint: vec4<f32> }
@group(0) @binding(0) var table: texture_2d_array<f32>;
@group(0) @binding(1) var table_sampler: sampler;
@group(0) @binding(2) var functions: texture_2d<f32>;
@group(0) @binding(3) var<storage, read> questions: array<Question>;
@group(0) @binding(4) var<storage, read_write> answers: array<vec4<f32>>;
@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x < arrayLength(&questions) {
        let q = questions[id.x];
        let frame = mat3x3<f32>(FRAME);
        let rgb = diffract_rgb(q.light.xyz, q.viewer.xyz, frame, q.footprint.xy, q.footprint.zw, table, table_sampler, functions);
        answers[id.x] = vec4<f32>(rgb, 1.0);
    }
}
"""
# Bytes of a texel of table.ktx2 and of functions.ktx2.
FORMATS = {"rgba16float": 8, "rgba32float": 16}
STANDARD_FRAME = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def device():
    """Returns a device of the driver that VK_DRIVER_FILES names, or of the system."""
    return wgpu.gpu.request_adapter_sync(power_preference="high-performance").request_device_sync()


def texture(gpu, path, form):
    """Returns a view of the texture in a KTX2 file without supercompression."""
    data = Path(path).read_bytes()
    width, height, _, layers, _, count = struct.unpack_from("<6I", data, 20)
    depth = max(layers, 1)
    usage = wgpu.TextureUsage.TEXTURE_BINDING | wgpu.TextureUsage.COPY_DST
    made = gpu.create_texture(size=(width, height, depth), mip_level_count=count, format=form, usage=usage)
    for level in range(count):
        start, length = struct.unpack_from("<2Q", data, 80 + 24 * level)
        columns, rows = max(width >> level, 1), max(height >> level, 1)
        layout = {"bytes_per_row": columns * FORMATS[form], "rows_per_image": rows}
        gpu.queue.write_texture({"texture": made, "mip_level": level}, data[start : start + length], layout, (columns, rows, depth))
    return made.create_view(dimension="2d-array" if layers else "2d")


class Material:
    """Material in the folder of an export. `frame`: tangent, bitangent and normal in the space of the directions."""

    def __init__(self, gpu, folder, frame=STANDARD_FRAME):
        folder = Path(folder)
        columns = ", ".join(str(float(number)) for axis in frame for number in axis)
        code = (folder / "material.wgsl").read_text() + MAIN.replace("FRAME", columns)
        self.gpu = gpu
        self.pipeline = gpu.create_compute_pipeline(layout="auto", compute={"module": gpu.create_shader_module(code=code), "entry_point": "main"})
        self.textures = [
            texture(gpu, folder / "table.ktx2", "rgba16float"),
            gpu.create_sampler(mag_filter="linear", min_filter="linear", mipmap_filter="nearest"),
            texture(gpu, folder / "functions.ktx2", "rgba32float"),
        ]

    def rgb(self, light, viewer, footprint):
        """Returns linear sRGB of f cos(theta), [question][3], for arrays [question][3] of unit vectors and [question][4] of dx and dy."""
        count = len(light)
        questions = np.zeros((count, 12), np.float32)
        questions[:, 0:3], questions[:, 4:7], questions[:, 8:12] = light, viewer, footprint
        asked = self.gpu.create_buffer_with_data(data=questions, usage=wgpu.BufferUsage.STORAGE)
        answered = self.gpu.create_buffer(size=16 * count, usage=wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_SRC)
        buffers = [{"buffer": buffer, "offset": 0, "size": buffer.size} for buffer in (asked, answered)]
        entries = [{"binding": i, "resource": resource} for i, resource in enumerate(self.textures + buffers)]
        group = self.gpu.create_bind_group(layout=self.pipeline.get_bind_group_layout(0), entries=entries)
        commands = self.gpu.create_command_encoder()
        work = commands.begin_compute_pass()
        work.set_pipeline(self.pipeline)
        work.set_bind_group(0, group)
        work.dispatch_workgroups((count + 63) // 64)
        work.end()
        self.gpu.queue.submit([commands.finish()])
        return np.frombuffer(self.gpu.queue.read_buffer(answered), np.float32).reshape(count, 4)[:, :3]
