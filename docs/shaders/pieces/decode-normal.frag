// [shared] decode_normal: shading of a rasterised hit.
precision highp float;

layout(location = 0) flat in vec3 encoded;
layout(location = 1) flat in vec3 direction;
layout(location = 0) out vec4 result;

void main() {
    vec3 normal = encoded * 2.0 - 1.0;
    result = vec4(normal, max(dot(normal, normalize(direction)), 0.0));
}
