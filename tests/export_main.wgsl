// Answers a question a thread: the end of a program whose begin is the exported shader.
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
        answers[id.x] = vec4<f32>(diffract_rgb(q.light.xyz, q.viewer.xyz, FRAME, q.footprint.xy, q.footprint.zw, table, table_sampler, functions), 1.0);
    }
}
