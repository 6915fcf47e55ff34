// A material of `diffract export` in three.js: diffraction under the lights of the scene.

import * as THREE from "three";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";

const VERTEX = /* glsl */ `
#include <common>
#include <shadowmap_pars_vertex>
#ifndef USE_TANGENT
attribute vec4 tangent; // zero where a geometry has none
#endif
varying vec3 diffract_place, diffract_normal; // in the space of the camera, as are all directions
varying vec4 diffract_tangent;
varying vec2 diffract_coordinates;
void main() {
    #include <beginnormal_vertex>
    #include <defaultnormal_vertex>
    #include <begin_vertex>
    #include <project_vertex>
    #include <worldpos_vertex>
    #include <shadowmap_vertex>
    diffract_place = mvPosition.xyz;
    diffract_normal = transformedNormal;
    diffract_tangent = vec4((modelViewMatrix * vec4(tangent.xyz, 0.0)).xyz, tangent.w);
    diffract_coordinates = uv;
}`;

const FRAGMENT = /* glsl */ `
#include <common>
#include <packing>
#include <lights_pars_begin>
#include <shadowmap_pars_fragment>
#include <shadowmask_pars_fragment>
uniform mat3 normalMatrix;
uniform vec3 diffract_along; // direction of T where the geometry tells none, in its own space
uniform float diffract_turn; // of T and B about N [rad]
varying vec3 diffract_place, diffract_normal;
varying vec4 diffract_tangent;
varying vec2 diffract_coordinates;

// Returns T, B and N toward the viewer, orthonormal.
mat3 diffract_frame(vec3 viewer) {
    float side = gl_FrontFacing ? 1.0 : -1.0; // the back shows the heights from below: T stays, B turns over with N
    vec3 n = side * normalize(diffract_normal);
    vec3 dx = dFdx(diffract_place), dy = dFdy(diffract_place);
    vec2 right = dFdx(diffract_coordinates), up = dFdy(diffract_coordinates); // of (u, v)
    float area = right.x * up.y - right.y * up.x;
    vec3 t = normalMatrix * diffract_along;
    float hand = 1.0;
    if (dot(diffract_tangent.xyz, diffract_tangent.xyz) > 1e-12) {
        t = diffract_tangent.xyz;
        hand = diffract_tangent.w < 0.0 ? -1.0 : 1.0;
    } else if (area != 0.0) {
        // The direction in which u grows and v stays.
        t = (dx * up.y - dy * right.y) * sign(area);
        hand = side * sign(area);
    }
    // At a silhouette interpolated normals turn away from the viewer before the surface does.
    float away = dot(n, viewer);
    n = away < 0.0 ? normalize(n - away * viewer) : n;
    t -= dot(t, n) * n;
    t = dot(t, t) > 1e-12 ? normalize(t) : normalize(cross(n, abs(n.x) < 0.5 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0)));
    vec3 b = hand * cross(n, t);
    float c = cos(diffract_turn), s = sin(diffract_turn);
    return mat3(c * t + s * b, c * b - s * t, n);
}

vec3 diffract_lit(vec3 light, vec3 irradiance, vec3 viewer, mat3 frame) {
    vec2 uv = diffract_uv(light, viewer, frame);
    vec2 dx = 0.5 * dFdx(uv), dy = 0.5 * dFdy(uv);
    // The cosine to the viewer is at least its change within the pixel, which averages over what is seen of it.
    float cosine = dot(viewer, frame[2]);
    float least = 0.5 * length(vec2(dFdx(cosine), dFdy(cosine)));
    vec3 seen = normalize(viewer + max(min(least, 1.0) - cosine, 0.0) * frame[2]);
    return irradiance * diffract_rgb(light, seen, frame, dx, dy);
}

void main() {
    vec3 viewer = isOrthographic ? vec3(0.0, 0.0, 1.0) : normalize(-diffract_place);
    mat3 frame = diffract_frame(viewer);
    vec3 radiance = vec3(0.0);
    #if NUM_DIR_LIGHTS > 0
    for (int i = 0; i < NUM_DIR_LIGHTS; i++) {
        radiance += diffract_lit(directionalLights[i].direction, directionalLights[i].color, viewer, frame);
    }
    #endif
    #if NUM_POINT_LIGHTS > 0
    for (int i = 0; i < NUM_POINT_LIGHTS; i++) {
        vec3 to = pointLights[i].position - diffract_place;
        float fall = getDistanceAttenuation(length(to), pointLights[i].distance, pointLights[i].decay);
        radiance += diffract_lit(normalize(to), fall * pointLights[i].color, viewer, frame);
    }
    #endif
    gl_FragColor = vec4(radiance * getShadowMask(), 1.0);
    #include <tonemapping_fragment>
    #include <colorspace_fragment>
}`;

// Returns a plain image of an export as a texture that is read texel by texel.
async function image(address, type) {
    const texture = await new EXRLoader().setDataType(type).loadAsync(address);
    texture.generateMipmaps = false;
    texture.minFilter = texture.magFilter = THREE.NearestFilter;
    return texture;
}

/**
 * Loads the folder of an export as a THREE.ShaderMaterial for the directional and point lights of the scene.
 *
 * T, the direction along the rows of the height field, is that of the geometry's `tangent`, else the one in which u of its `uv` grows, else `along` (in its own space);
 * `turn` [radians] turns T about the normal.
 */
export async function loadDiffract(folder, { along = [1, 0, 0], turn = 0 } = {}) {
    const at = (name) => `${folder.replace(/\/$/, "")}/${name}`;
    const text = async () => {
        const answer = await fetch(at("material2d.es.glsl"));
        if (!answer.ok) throw new Error(`${at("material2d.es.glsl")}: ${answer.status}; give the folder of diffract export`);
        return answer.text();
    };
    const [table, functions, reading] = await Promise.all([
        image(at("table2d.exr"), THREE.HalfFloatType),
        image(at("functions.exr"), THREE.FloatType),
        text(),
    ]);
    // EXRLoader puts the last line first.
    const glsl = reading.replace("DIFFRACT_LAST_ROW_FIRST = false", "DIFFRACT_LAST_ROW_FIRST = true");
    return new THREE.ShaderMaterial({
        name: "diffract",
        lights: true,
        side: THREE.DoubleSide,
        uniforms: {
            ...THREE.UniformsUtils.clone(THREE.UniformsLib.lights),
            diffract_table: { value: table },
            diffract_functions: { value: functions },
            diffract_along: { value: new THREE.Vector3(...along) },
            diffract_turn: { value: turn },
        },
        vertexShader: VERTEX,
        fragmentShader: `${glsl}\n${FRAGMENT}`,
    });
}
