#version 460
#extension GL_GOOGLE_include_directive : require
// Transforms the vector to the viewer to the tangent frame of each vertex. The vector is linear in the position, and
// only linear quantities may be interpolated: the fragment stage normalises. It also gets the frame, because
// interpolated frames are not orthonormal.
#include "frame.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 tangent; // w: handedness, B = w N x T
layout(location = 3) in vec2 uv;

layout(location = 0) out vec3 view; // not normalised: its length is the distance of an eye
layout(location = 1) out vec2 pigment_uv;
layout(location = 2) out vec3 world;
layout(location = 3) out vec3 world_normal;
layout(location = 4) out vec3 world_tangent;
layout(location = 5) out vec3 world_bitangent;

void main() {
    world_normal = normal;
    world_tangent = tangent.xyz;
    world_bitangent = tangent.w * cross(normal, tangent.xyz);
    mat3 tangent_from_world = transpose(mat3(world_tangent, world_bitangent, world_normal));
    view = tangent_from_world * toward_viewer(position);
    pigment_uv = vec2(uv.x, 1.0 - uv.y); // v grows upward in meshes, rows of a texture downward
    world = position;
    gl_Position = frame.clip_from_world * vec4(position, 1.0);
}
