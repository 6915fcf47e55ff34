//! Texts of an export for game engines, with what these engines put around them: programs for the device, where the engines themselves are not.

/// Built-in variables and functions of Godot, which a compute shader has not.
const GODOT_HEAD: &str = "#version 450
layout(local_size_x = 64) in;
struct Question { vec4 light; vec4 viewer; vec4 footprint; };
layout(set = 0, binding = 2, std430) readonly buffer Questions { Question questions[]; };
layout(set = 0, binding = 3, std430) writeonly buffer Answers { vec4 answers[]; };
Question question;
vec3 LIGHT, VIEW, ALBEDO, NORMAL, TANGENT, BINORMAL, SPECULAR_LIGHT = vec3(0.0), LIGHT_COLOR = vec3(1.0);
float ATTENUATION = 1.0;
bool FRONT_FACING;
float change(float x) { return 0.0; }
#define dFdx(x) (vec2(change(x)) + 2.0 * question.footprint.xy)
#define dFdy(x) (vec2(change(x)) + 2.0 * question.footprint.zw)
vec2 change(vec2 x) { return vec2(0.0); }
#define varying
";

/// Asks a shader of Godot once from the front and once from the back, which shows the frame as its mesh tells it from the front.
const GODOT_MAIN: &str = "
void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < uint(questions.length())) {
        question = questions[i];
        mat3 frame = FRAME;
        FRONT_FACING = i % 2 == 0;
        LIGHT = question.light.xyz;
        VIEW = question.viewer.xyz;
        TANGENT = frame[0];
        BINORMAL = FRONT_FACING ? frame[1] : -frame[1];
        NORMAL = frame[2];
        fragment();
        light();
        answers[i] = vec4(SPECULAR_LIGHT, 1.0);
    }
}
";

/// Returns the shader of Godot as GLSL, with colours that are not clipped, for an expression of the frame.
pub fn godot_in_glsl(text: &str, frame: &str) -> String {
    let changes = [
        ("shader_type spatial;", ""),
        ("render_mode cull_disabled, ambient_light_disabled;", ""),
        (
            "uniform sampler2D diffract_table : filter_nearest;",
            "layout(set = 0, binding = 0) uniform sampler2D diffract_table;",
        ),
        (
            "uniform sampler2D diffract_functions : filter_nearest;",
            "layout(set = 0, binding = 1) uniform sampler2D diffract_functions;",
        ),
        (
            "uniform float diffract_turn : hint_range(-180.0, 180.0) = 0.0;",
            "const float diffract_turn = 0.0;",
        ),
        ("0.5 * length(vec2(dFdx(cosine), dFdy(cosine)))", "change(cosine)"),
        ("max(colour, vec3(0.0))", "colour"),
    ];
    format!("{GODOT_HEAD}{}{}", changed(text, &changes), GODOT_MAIN.replace("FRAME", frame))
}

/// Returns `text` with each of the `changes`, which have to be possible.
fn changed(text: &str, changes: &[(&str, &str)]) -> String {
    changes.iter().fold(text.to_owned(), |text, (old, new)| {
        assert_eq!(text.matches(old).count(), 1, "{old}");
        text.replace(old, new)
    })
}

/// Derivatives, questions, answers and textures for HLSL of engines.
const HLSL_HEAD: &str = "
struct Question { float4 light; float4 viewer; float4 footprint; };
[[vk::binding(0, 0)]] Texture2D table;
[[vk::binding(1, 0)]] SamplerState table_sampler;
[[vk::binding(2, 0)]] Texture2D functions;
[[vk::binding(3, 0)]] StructuredBuffer<Question> questions;
[[vk::binding(4, 0)]] RWStructuredBuffer<float4> answers;
static float4 change;
#define ddx(x) (2.0 * change.xy)
#define ddy(x) (2.0 * change.zw)
";

const HLSL_MAIN: &str = "
[numthreads(64, 1, 1)]
void main(uint3 id : SV_DispatchThreadID) {
    uint count, stride;
    questions.GetDimensions(count, stride);
    if (id.x < count) {
        Question q = questions[id.x];
        change = q.footprint;
        answers[id.x] = float4(colour(q.light.xyz, q.viewer.xyz, FRAME), 1.0);
    }
}
";

const UNITY_CALL: &str = "
float3 colour(float3 light, float3 viewer, float3x3 frame) {
    UnityTexture2D first, second;
    first.tex = table;
    second.tex = functions;
    float3 found;
    Diffract_float(first, second, light, viewer, 2.0 * frame[0] + 0.1 * frame[2], frame[1], 3.0 * frame[2], found);
    return found;
}
";

/// Returns the function for Unity with the file that it includes as a program of HLSL.
pub fn unity_in_hlsl(text: &str, included: &str, frame: &str) -> String {
    let text = changed(text, &[("#include \"material2d.hlsl\"", included)]);
    let main = HLSL_MAIN.replace("FRAME", frame);
    format!("{HLSL_HEAD}struct UnityTexture2D {{ Texture2D tex; }};\n{text}{UNITY_CALL}{main}")
}

/// Returns the code of a Custom node of Unreal as a program of HLSL, with functions outside of their structure: glslang does not compile methods that call each other. B of
/// Unreal points down.
pub fn unreal_in_hlsl(text: &str, frame: &str) -> String {
    let text = changed(
        text,
        &[("\nstruct DiffractFunctions {\n", "\n"), ("DiffractFunctions diffract_functions;\n", "")],
    );
    let text = text.replace("diffract_functions.", "");
    let (declared, body) =
        text.split_once("\n};\n\n// The colour of the pixel.").expect("the body of the node");
    let main = HLSL_MAIN.replace("FRAME", frame);
    format!(
        "{HLSL_HEAD}struct Inputs {{ float3x3 TangentToWorld; float3 CameraVector; }};
{declared}
float3 node(Inputs Parameters, Texture2D Table, Texture2D Functions, float3 Light) {{ // {body}}}
float3 colour(float3 light, float3 viewer, float3x3 frame) {{
    Inputs inputs;
    inputs.CameraVector = viewer;
    inputs.TangentToWorld = float3x3(frame[0], -frame[1], frame[2]);
    return node(inputs, table, functions, light);
}}
{main}"
    )
}
