// kd-restart (Foley and Sugerman 2005).
#include "kd.glsl"
#include "kd-descent.glsl"

bool trace(Ray ray, bool any, inout Hit hit) {
    vec2 span = slab(ray, sceneLow, sceneHigh, hit.t);
    if (span.x > span.y) {
        return false;
    }
    float end = span.y;
    uint node = 0u;
    for (;;) {
        uvec4 record;
        for (;;) {
            record = nodes[node];
            uint axis = record.y;
            if (axis == LEAF) {
                break;
            }
            float t = (uintBitsToFloat(record.x) - ray.origin[axis]) * ray.inverse[axis];
            bool rightFirst = ray.direction[axis] < 0.0;
            uint near = rightFirst ? record.w : record.z;
            uint far = rightFirst ? record.z : record.w;
            if (t >= span.y) {
                node = near;
            } else if (t <= span.x) {
                node = far;
            } else {
                node = near;
                span.y = t;
            }
        }
        uint last = record.z + record.w;
        for (uint i = record.z; i < last; i++) {
            intersect(references[i], ray, hit);
            if (any && hit.triangle != NONE) {
                return true;
            }
        }
        if (hit.t <= span.y || span.y >= end) {
            return hit.triangle != NONE;
        }
        node = 0u;
        span = vec2(span.y, end);
    }
}
