// [shared] vertex_position: position transformed, for binning.
uniform mat4 transform;

layout(location = 0) in vec3 position;

void main() {
    // The standalone compiler does not know products of matrix and vector.
    gl_Position = transform[0] * position.x + transform[1] * position.y + transform[2] * position.z + transform[3];
}
