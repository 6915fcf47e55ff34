#version 460
// Displayed picture in the window: one setting, or two with a movable split between them.

layout(set = 0, binding = 0) uniform sampler2D left;
layout(set = 0, binding = 1) uniform sampler2D right;

layout(push_constant) uniform Window {
    vec2 area;       // area of the picture in the window, from its upper left corner [pixels]
    vec2 left_size;  // drawn size of each picture, from the upper left corner [pixels]
    vec2 right_size;
    float split;     // first column of the right picture
} window;

layout(location = 0) out vec4 code;

vec4 at(sampler2D picture, vec2 size) {
    if (size == window.area) {
        return texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
    }
    // Clamped to the last drawn pixel: beyond it are pixels of another picture.
    vec2 place = clamp(gl_FragCoord.xy / window.area * size, vec2(0.5), size - 0.5);
    return texture(picture, place / vec2(textureSize(picture, 0)));
}

void main() {
    if (any(greaterThanEqual(gl_FragCoord.xy, window.area))) {
        discard;
    }
    if (gl_FragCoord.x < window.split) {
        code = at(left, window.left_size);
    } else {
        code = at(right, window.right_size);
    }
}
