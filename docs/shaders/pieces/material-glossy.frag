// [reflections] glossy: a material of albedo, roughness and reflectance.
precision highp float;
precision highp int;

#include "reflections/material.glsl"

flat in uint material;
flat in vec3 normal;
flat in vec3 toLight;
flat in vec3 toViewer;
layout(location = 0) out vec3 result;

void main() {
    result = shadeGlossy(materials[2u * material], materials[2u * material + 1u], normal, toLight, toViewer);
}
