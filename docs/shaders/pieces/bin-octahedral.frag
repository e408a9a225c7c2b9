// [reflections] bin_octahedral: the bin of a direction on an unfolded octahedron (Cigolle et al. 2014).
precision highp float;
precision highp int;

// Columns and rows.
uniform vec2 size;

flat in vec3 direction;
out uint result;

void main() {
    vec2 point = direction.xy / (abs(direction.x) + abs(direction.y) + abs(direction.z));
    vec2 folded = (1.0 - abs(point.yx)) * vec2(point.x >= 0.0 ? 1.0 : -1.0, point.y >= 0.0 ? 1.0 : -1.0);
    vec2 uv = (direction.z < 0.0 ? folded : point) * 0.5 + 0.5;
    uvec2 cell = uvec2(clamp(uv * size, vec2(0.0), size - 1.0));
    result = cell.x + cell.y * uint(size.x);
}
