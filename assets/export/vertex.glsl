#version 300 es
// Places the corners of a triangle that covers the picture behind all else, or those of the mesh, as the camera or the light sees it.
precision highp float;
precision highp int;

layout(location = 0) in vec4 packed_place; // position in the unit sphere, from 0 to 1; w: 1 if B = N x T, 0 if opposite
layout(location = 1) in vec4 packed_axes;  // N and T, folded onto squares through an octahedron

uniform int view;
uniform int shape;
uniform vec2 size;
uniform mat3 camera;
uniform float eye_distance;
uniform float focal;
uniform mat3 light_axes;

const int SHAPE_MESH = 3;
const int VIEW_SHAPE = 0, VIEW_SHADOW = 3;

// Two programs draw the same depths.
invariant gl_Position;

out vec3 mesh_place;
out vec3 mesh_view;      // to the eye in components of T, B and N, linear in the position
out vec3 mesh_normal;
out vec3 mesh_tangent;
out vec3 mesh_bitangent;

vec3 unfolded(vec2 place) {
    float z = 1.0 - abs(place.x) - abs(place.y);
    vec2 side = vec2(place.x < 0.0 ? -1.0 : 1.0, place.y < 0.0 ? -1.0 : 1.0);
    return normalize(vec3(z < 0.0 ? (1.0 - abs(place.yx)) * side : place, z));
}

void main() {
    mesh_place = 2.0 * packed_place.xyz - 1.0;
    mesh_normal = unfolded(packed_axes.xy);
    mesh_tangent = unfolded(packed_axes.zw);
    mesh_bitangent = (packed_place.w > 0.5 ? 1.0 : -1.0) * cross(mesh_normal, mesh_tangent);
    mesh_view = (eye_distance * camera[2] - mesh_place) * mat3(mesh_tangent, mesh_bitangent, mesh_normal);
    if (view == VIEW_SHADOW) {
        vec3 seen = mesh_place * light_axes;
        gl_Position = vec4(seen.xy, -seen.z, 1.0);
    } else if (view == VIEW_SHAPE && shape == SHAPE_MESH) {
        vec3 seen = mesh_place * camera;
        float depth = eye_distance - seen.z, near = max(eye_distance - 1.01, 0.01), far = eye_distance + 1.01;
        vec2 across = focal * min(size.x, size.y) / size * seen.xy;
        gl_Position = vec4(across, ((far + near) * depth - 2.0 * far * near) / (far - near), depth);
    } else {
        gl_Position = vec4(vec2(gl_VertexID & 1, gl_VertexID >> 1) * 4.0 - 1.0, 1.0, 1.0);
    }
}
