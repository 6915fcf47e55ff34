// Everything that shaders and Rust share: limits, blocks, bindings. Its twin is src/render/interface.rs; the test
// `blocks_mean_the_same_to_rust_and_to_shaders` sends every field through the device and back.

const int MAX_LIGHTS = 4;
const int UV_BINS = 256; // entries of `combs` over |(u, v)| in 0 ... 2

layout(set = 0, binding = 0, std140) uniform Frame {
    mat4 clip_from_world;
    vec4 eye;                       // xyz: position of the viewer in the world
    vec4 lights[MAX_LIGHTS];        // xyz: unit vector to the light in the world; w: irradiance / pi
    vec4 base_color;                // rgb: albedo of the pigment, linear sRGB; w: 1 where the pigment texture counts
    ivec4 counts;                   // x: lights
} frame;

layout(set = 0, binding = 1, std140) uniform Optics {
    vec2 texture_size;              // texels of a layer along f_x and f_y
    vec2 origin;                    // centre of the texel of f = 0, in texels from the texture's corner
    vec2 texels_per_frequency;      // L_x, L_y [um]
    vec2 band;                      // largest |f_x|, |f_y| that holds anything [1/um]
    float sigma;                    // standard deviation of the Gaussian window [um]
    float normal_reflectance;       // R0 of Schlick
    float bands_per_z;              // bands of z per unit of k|w| [um]
    float last_column;              // number of the last column of `coefficients`; the first is 0
    float pairs_per_z;              // pairs of terms that k|w| needs: pairs_per_z k|w| + fewest_pairs, rounded up
    float fewest_pairs;
} optics;

// Spectra of the basis functions: RGBA = Re, Im of term 2p, Re, Im of term 2p + 1, relative to the flat mirror's peak.
// Pair p of terms in band b of z is layer p Z_BANDS + b.
layout(set = 0, binding = 2) uniform sampler2DArray layers;

// c_2p, c_2p+1 as (Re, Im, Re, Im) over the band of z, in the layers of the same numbers. Small tables are textures
// because software devices read those eight lanes at a time, and buffers lane by lane.
layout(set = 0, binding = 3) uniform sampler2DArray coefficients;

// Wavelength combs: row of `nodes` and number of nodes for each bin of |(u, v)|.
layout(set = 0, binding = 4, std430) readonly buffer Combs { ivec2 combs[]; };

// A comb a row: XYZ weight and wavenumber 1/lambda [1/um] of each node, the wavenumber growing.
layout(set = 0, binding = 5) uniform sampler2D nodes;

layout(set = 0, binding = 6) uniform sampler2D pigment;
