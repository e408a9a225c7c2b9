// What the passes of the sort share.

layout(local_size_x = 64) in;

layout(std430, binding = 6) readonly buffer Hits {
    // Rays that were traced.
    uint elements;
    // By ray, what it hit; the largest number is a miss.
    uint instances[];
};

layout(std430, binding = 7) readonly buffer Shaders {
    // By instance.
    uint shaders[];
};

layout(std430, binding = 8) buffer Buckets {
    uint buckets[];
};

layout(std430, binding = 9) buffer Order {
    uint order[];
};

uint bucketOf(uint element) {
    uint instance = instances[element];
    if (instance == 0xFFFFFFFFu) {
        return 0u;
    }
    return shaders[instance] + 1u;
}
