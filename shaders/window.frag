#version 460
// The displayed picture in the window: one setting, or two with a movable split between them.

layout(set = 0, binding = 0) uniform sampler2D left;
layout(set = 0, binding = 1) uniform sampler2D right;

layout(push_constant) uniform Window {
    vec2 area;       // pixels of the window that the picture takes, from its upper left corner
    vec2 left_size;  // pixels of the picture in each image, from the upper left corner
    vec2 right_size;
    float split;     // column where the right picture begins
} window;

layout(location = 0) out vec4 code;

vec4 at(sampler2D picture, vec2 size) {
    if (size == window.area) {
        return texelFetch(picture, ivec2(gl_FragCoord.xy), 0);
    }
    // Not beyond the last pixel that was drawn: what lies there is of another picture.
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
