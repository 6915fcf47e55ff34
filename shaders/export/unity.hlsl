// Diffraction of a surface as a Custom Function of Unity's Shader Graph: type File, name Diffract. material2d.hlsl stands beside this file.
//
// Table, Functions: table2d.exr and functions.exr. Light, Viewer: unit vectors from the surface. Tangent, Bitangent, Normal: of the mesh. All directions are of one
// space. Colour: linear sRGB of f cos(theta_light) [1/sr], to be multiplied by pi times the colour of the light; components may be negative.

#ifndef DIFFRACT_UNITY
#define DIFFRACT_UNITY

#define DIFFRACT_LAST_ROW_FIRST true
#include "material2d.hlsl"

void Diffract_float(UnityTexture2D Table, UnityTexture2D Functions, float3 Light, float3 Viewer, float3 Tangent, float3 Bitangent, float3 Normal, out float3 Colour)
{
    float3 n = normalize(Normal);
    float3 t = normalize(Tangent - dot(Tangent, n) * n);
    float3 b = cross(n, t);
    float3x3 frame = float3x3(t, dot(b, Bitangent) < 0.0 ? -b : b, n);
    float2 uv = diffract_uv(Light, Viewer, frame);
    Colour = diffract_rgb(Light, Viewer, frame, 0.5 * ddx(uv), 0.5 * ddy(uv), Table.tex, Functions.tex);
}

#endif
