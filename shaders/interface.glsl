// Everything that shaders and Rust share: limits, blocks, bindings. Its twin is src/render/interface.rs; the test
// `blocks_mean_the_same_to_rust_and_to_shaders` sends every field through the device and back.

const int MAX_LIGHTS = 4;
const int UV_BINS = 256; // entries of `combs` over |(u, v)| in 0 ... 2
const int OCTAVES = 20;  // of rays near the mirror direction, with finer lines each
const float FINER = 4.0; // points of those lines to one of the others

// A sample of a picture; src/render/sampling.rs says more. Fields to come, as of lights with an extent, are functions of `index` and `seed`.
struct Sample {
    vec2 jitter;                    // place in the pixel, from its centre: x to the right, y downward [pixels]
    float footprint;                // standard deviation of the part of the pixel filter that shading averages over [pixels]
    uint index;                     // number of the sample, from 0
    uint count;                     // samples of the picture
    uint seed;                      // low bits of the sequence's seed
};

layout(set = 0, binding = 0, std140) uniform Frame {
    mat4 clip_from_world;
    vec4 eye;                       // xyz: position of the viewer in the world
    vec4 lights[MAX_LIGHTS];        // xyz: unit vector to the light in the world; w: irradiance / pi
    vec4 base_color;                // rgb: albedo of the pigment, linear sRGB; w: 1 where the pigment texture counts
    ivec4 counts;                   // x: lights
    Sample at;                      // which sample of the picture the frame is
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

layout(set = 0, binding = 19, std140) uniform Lines {
    vec2 across;                    // L across the lines of constant f_x and of constant f_y [um]: they stand at m/L
    vec2 along;                     // L along them [um]
    vec2 origin;                    // number of the point and of the line of f = 0
    float from;                     // max(|u|, |v|) from which on lines are read
    float unit;                     // intensities on lines over those of the plane
    float first_column;             // wavenumber of the first column of the weights [1/um]
    float columns_per_wavenumber;   // [um]
    float first_row;                // log2 of the first row's distance of nodes [1/um]
    float rows_per_octave;
    float last_column;
    float nearest;                  // max(|u|, |v|) that rays nearer to the mirror direction are taken for
    vec4 near[OCTAVES];             // xy: number of the point and of the line of f = 0, for each octave of rays below `from`
} lines_at;

// Spectra on lines: layer (pair / GROUPED) Z_BANDS + band, those of constant f_y behind all of constant f_x; row by line,
// column by point and, side by side, by pair of a group. RGBA as in `layers`.
layout(set = 0, binding = 17) uniform sampler2DArray lines;

// The same where numbers have 16 bits and an even number of pairs stands side by side: two pairs to a texel, half as many reads.
layout(set = 0, binding = 20) uniform usampler2DArray packed_lines;

// Weights of nodes that stand where a ray crosses lines: XYZ times the squared wavenumber, per distance of the nodes. W of the
// first two texels of a row: the wavenumbers between which the eye sees enough [1/um].
layout(set = 0, binding = 18) uniform sampler2D line_weights;
