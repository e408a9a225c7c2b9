// [shared] vertex: position transformed, normal handed on.
uniform mat4 transform;

layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
out vec3 handedOn;

void main() {
    // The standalone compiler does not know products of matrix and vector.
    gl_Position = transform[0] * position.x + transform[1] * position.y + transform[2] * position.z + transform[3];
    handedOn = normal;
}
