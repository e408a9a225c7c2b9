// What lies around the traversal: camera, shading, shadow ray, output.

uniform vec3 eye;
uniform vec3 corner;
uniform vec3 right;
uniform vec3 down;
uniform vec3 light;
uniform vec3 albedo;

vec3 cameraDirection(vec2 pixel) {
    return normalize(corner + pixel.x * right + pixel.y * down);
}

vec3 hitNormal(vec3 n0, vec3 n1, vec3 n2, float u, float v) {
    return normalize((1.0 - u - v) * n0 + u * n1 + v * n2);
}

vec3 hitPoint(vec3 origin, vec3 direction, float t) {
    return origin + t * direction;
}

// Off the surface, to the side that the ray came from.
vec3 shadowOrigin(vec3 point, vec3 normal, vec3 direction) {
    return point + 0.001 * faceforward(normal, direction, normal);
}

vec4 outputColour(float lit, float visibility) {
    return vec4(albedo * (lit * visibility), 1.0);
}
