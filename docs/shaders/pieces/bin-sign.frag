// [reflections] bin_sign: the bin of a direction by its signs.
precision highp float;
precision highp int;

flat in vec3 direction;
out uint result;

void main() {
    result = (direction.z > 0.0 ? 4u : 0u) + (direction.y > 0.0 ? 2u : 0u) + (direction.x > 0.0 ? 1u : 0u);
}
