// Set 0 of the graphics stages: the frame. Its twin is src/render/frame_set.rs; the test
// `blocks_mean_the_same_to_rust_and_to_shaders` sends every field through the device and back.

// What `emitter` holds in w.
const float FAR_AWAY = 0.0, ALL_AROUND = 1.0, TO_ONE_SIDE = 2.0;

// A sample of a picture; src/render/sampling.rs says more.
struct Sample {
    vec2 jitter;                    // place in the pixel, from its centre: x to the right, y downward [pixels]
    float footprint;                // standard deviation of the part of the pixel filter that shading averages over [pixels]
    uint index;                     // number of the sample among those of its light, from 0
    uint count;                     // samples of the picture that draw the light
    uint seed;                      // low bits of the sequence's seed
};

layout(set = 0, binding = 0, std140) uniform Frame {
    mat4 clip_from_world;
    vec4 eye;                       // xyz: position of the viewer in the world
    vec4 light;                     // xyz: unit vector to the light in the world; w: variance of the directions that it stands for. Of a lamp: a point of it, and the variance of points
    vec4 emitter;                   // w: FAR_AWAY, or what a lamp is; xyz: the middle of one that emits ALL_AROUND, the normal of one that emits TO_ONE_SIDE
    vec4 irradiance;                // rgb: of a surface that faces the light, over pi, linear sRGB; of a lamp at distance 1 straight before it. w: how much the mirrored radiance of surroundings counts
    vec4 base_color;                // rgb: albedo of the pigment, linear sRGB; w: 1 where the pigment texture counts
    vec4 grooves;                   // xy: cosine and sine of the angle by which the patch is turned, where it is one for all of an object
    vec4 surroundings;              // xy: cosine and sine of their rotation; z: what their picture's 1 stands for; w: variance of the specular order
    mat4 shadow_from_world;         // to the clip space of the light's depth map
    Sample at;                      // which sample of the picture the frame is
} frame;
