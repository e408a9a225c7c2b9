// No traversal: the ray goes to a ray unit, and its answer comes back, as a message of two vec4 and one of one. Only the registers of frame.frag are counted with it.
layout(std430, binding = 0) buffer Unit {
    vec4 messages[];
};

bool trace(Ray ray, bool any, inout Hit hit) {
    uint slot = any ? 3u : 0u;
    messages[slot] = vec4(ray.origin, hit.t);
    messages[slot + 1u] = vec4(ray.direction, 0.0);
    memoryBarrierBuffer();
    vec4 answer = messages[slot + 2u];
    if (answer.x < hit.t) {
        hit = Hit(answer.x, answer.y, answer.z, floatBitsToUint(answer.w));
    }
    return hit.triangle != NONE;
}
