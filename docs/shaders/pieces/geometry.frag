// [shared] geometry: the normal of a fragment, encoded.
precision highp float;

in vec3 normal;
out vec4 result;

void main() {
    result = vec4(normalize(normal) * 0.5 + 0.5, 1.0);
}
