// [reflections] diffuse: a material of albedo alone.
precision highp float;
precision highp int;

#include "reflections/material.glsl"

flat in uint material;
flat in vec3 normal;
flat in vec3 toLight;
layout(location = 0) out vec3 result;

void main() {
    result = shadeDiffuse(materials[2u * material], normal, toLight);
}
