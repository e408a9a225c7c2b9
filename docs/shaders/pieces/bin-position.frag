// [reflections] bin_position: the bin of an origin on a Morton curve of two bits per axis.
precision highp float;
precision highp int;

uniform vec3 low;
// Cells per unit of length.
uniform vec3 scale;

flat in vec3 origin;
out uint result;

uint spread(uint cell) {
    return (cell & 1u) | (cell & 2u) << 2;
}

void main() {
    uvec3 cell = uvec3(clamp((origin - low) * scale, vec3(0.0), vec3(3.0)));
    result = spread(cell.x) | spread(cell.y) << 1 | spread(cell.z) << 2;
}
