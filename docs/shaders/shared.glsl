// What all traversals share: rays, hits, the slab test and the triangle test.

precision highp float;
precision highp int;

const uint NONE = 0xFFFFFFFFu;

// Vertices and normals, three each, padded to vec4.
layout(std430, binding = 1) readonly buffer Triangles {
    vec4 triangles[];
};

struct Ray {
    vec3 origin;
    vec3 direction;
    vec3 inverse;
    bvec3 negative;
};

struct Hit {
    float t;
    float u;
    float v;
    uint triangle;
};

Ray makeRay(vec3 origin, vec3 direction) {
    vec3 inverse = 1.0 / direction;
    return Ray(origin, direction, inverse, lessThan(inverse, vec3(0.0)));
}

// Entry and exit of a box, up to distance `end`: Williams, Barrus, Morley and Shirley 2005.
vec2 slab(Ray ray, vec3 low, vec3 high, float end) {
    vec3 entry = (mix(low, high, ray.negative) - ray.origin) * ray.inverse;
    vec3 exit = (mix(high, low, ray.negative) - ray.origin) * ray.inverse;
    return vec2(max(max(entry.x, entry.y), max(entry.z, 0.0)), min(min(exit.x, exit.y), min(exit.z, end)));
}

// Moller and Trumbore 1997.
void intersect(uint triangle, Ray ray, inout Hit hit) {
    vec3 v0 = triangles[6u * triangle].xyz;
    vec3 e1 = triangles[6u * triangle + 1u].xyz - v0;
    vec3 e2 = triangles[6u * triangle + 2u].xyz - v0;
    vec3 p = cross(ray.direction, e2);
    float inverse = 1.0 / dot(e1, p);
    vec3 s = ray.origin - v0;
    float u = dot(s, p) * inverse;
    vec3 q = cross(s, e1);
    float v = dot(ray.direction, q) * inverse;
    float t = dot(e2, q) * inverse;
    if (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 && t < hit.t) {
        hit = Hit(t, u, v, triangle);
    }
}
