// Set 0 of the graphics stages: the frame. Its twin is src/render/frame_set.rs; the test
// `blocks_mean_the_same_to_rust_and_to_shaders` sends every field through the device and back.

// Value of `emitter.w` for a lamp that shines all around; 2 for one that shines to one side, 0 for a distant light.
const float ALL_AROUND = 1.0;

// Sample of a picture; see src/render/sampling.rs.
struct Sample {
    vec2 jitter;                    // position in the pixel, from its centre: x to the right, y downward [pixels]
    float footprint;                // standard deviation of the filter that shading averages over [pixels]
    uint index;                     // number of the sample among those of its light, from 0
    uint count;                     // samples of the picture that draw the light
    uint seed;                      // low bits of the sequence's seed
    uint turn;                      // of the choice of a direction: `slot_of` of light.glsl
    uint parts;                     // binary logarithm of the number of parts within which pixels differ
};

// Light of a sample; see `LightBlock` of src/render/frame_set.rs.
struct Light {
    vec4 toward;                    // xyz: unit vector to the light, or point of a lamp; w: variance of it
    vec4 emitter;                   // w: kind of emitter; xyz: centre of a lamp ALL_AROUND, or normal of one to a side; x of a distant light: length of the mean of the directions it stands for
    vec4 irradiance;                // rgb: over pi, facing the light; lamp: at distance 1. w: weight of surroundings
    mat4 shadow_from_world;         // to the clip space of the light's depth map
};

const int LIGHT_SLOTS = 32; // of src/render/frame_set.rs

layout(set = 0, binding = 0, std140) uniform Frame {
    mat4 clip_from_world;
    vec4 viewer;                    // in the world, homogeneous: w = 0 for a direction toward an orthographic camera
    vec4 base_color;                // rgb: albedo of the pigment, linear sRGB; w: 1 if the pigment texture is used
    vec4 grooves;                   // xy: cosine and sine of a constant angle of the patch; zw: size of a pixel in clip space
    vec4 surroundings;              // xy: cosine and sine of rotation; z: value of a stored 1; w: specular variance
    Sample at;                      // sample of the picture
    Light lights[LIGHT_SLOTS];      // lights that are drawn together, or directions of one light
} frame;

// Returns the vector from a point to the viewer; of length 1 for an orthographic camera.
vec3 toward_viewer(vec3 point) {
    return frame.viewer.xyz - frame.viewer.w * point;
}
