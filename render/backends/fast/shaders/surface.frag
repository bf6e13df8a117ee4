// A dielectric surface under ambient light, a sun that throws shadows and LAMPS lamps that do not:
// the reflection model of glTF 2.0 as pyrender computes it, so that both renderers look alike.

out vec4 picture;

#ifdef COLORED
in vec3 color;
#endif
#ifdef TEXTURED
uniform sampler2D surface_texture;
in vec2 place_in_texture;
#endif

#ifdef LIT
uniform vec3 eye;
uniform float roughness;
uniform vec3 ambient;
uniform vec3 to_sun;
uniform vec3 sun;
uniform sampler2DShadow shadow_map;
#if LAMPS > 0
uniform vec3 lamp_position[LAMPS];
uniform vec3 lamp[LAMPS];
#endif
in vec3 world_position;
in vec3 normal;
in vec3 place_in_light;

const float PI = 3.141592653589793;
const float MIRRORED = 0.04;

vec3 reflected(vec3 n, vec3 v, vec3 l, vec3 base)
{
    vec3 h = normalize(l + v);
    float nl = clamp(dot(n, l), 0.001, 1.0);
    float nv = clamp(abs(dot(n, v)), 0.001, 1.0);
    float nh = clamp(dot(n, h), 0.0, 1.0);
    float away = 1.0 - clamp(dot(v, h), 0.0, 1.0);
    float away2 = away * away;
    float fresnel = MIRRORED + (1.0 - MIRRORED) * away2 * away2 * away;
    float rough = clamp(roughness, MIRRORED, 1.0);
    float k = (rough + 1.0) * (rough + 1.0) / 8.0;
    float hidden = nv / (nv * (1.0 - k) + k) * (nl / (nl * (1.0 - k) + k));
    float a = rough * rough;
    float a2 = a * a;
    float spread = nh * nh * (a2 - 1.0) + 1.0;
    float facets = a2 / (PI * spread * spread);
    vec3 diffuse = (1.0 - fresnel) * (1.0 - MIRRORED) / PI * base;
    return nl * (diffuse + fresnel * hidden * facets / (4.0 * nl * nv + 0.001));
}

// Share of the sun that arrives: four bilinear comparisons, three by three texels wide.
float sunlit(float nl)
{
    if (any(greaterThan(abs(place_in_light - 0.5), vec3(0.5)))) {
        return 1.0;
    }
    float bias = max(0.001 * (1.0 - nl), 0.0001);
    vec2 texel = 0.5 / vec2(textureSize(shadow_map, 0));
    float depth = place_in_light.z - bias;
    float seen = texture(shadow_map, vec3(place_in_light.xy + vec2(-texel.x, -texel.y), depth));
    seen += texture(shadow_map, vec3(place_in_light.xy + vec2(texel.x, -texel.y), depth));
    seen += texture(shadow_map, vec3(place_in_light.xy + vec2(-texel.x, texel.y), depth));
    seen += texture(shadow_map, vec3(place_in_light.xy + vec2(texel.x, texel.y), depth));
    return 0.25 * seen;
}
#endif

#ifdef TEXTURED
vec3 linear(vec3 srgb)
{
    return mix(srgb / 12.92, pow((srgb + 0.055) / 1.055, vec3(2.4)), step(0.04045, srgb));
}
#endif

void main()
{
    vec3 base = vec3(1.0);
#ifdef TEXTURED
    base = texture(surface_texture, place_in_texture).rgb;
#ifdef LIT
    base = linear(base);
#endif
#endif
    vec3 light = base;
#ifdef LIT
    vec3 n = normalize(normal);
    vec3 v = normalize(eye - world_position);
    light = base * ambient;
    float nl = dot(n, to_sun);
    if (nl > 0.0) {
        light += sun * reflected(n, v, to_sun, base) * sunlit(nl);
    }
#if LAMPS > 0
    for (int i = 0; i < LAMPS; ++i) {
        vec3 way = lamp_position[i] - world_position;
        float square = dot(way, way);
        vec3 l = way * inversesqrt(square);
        if (dot(n, l) > 0.0) {
            light += lamp[i] / square * reflected(n, v, l, base);
        }
    }
#endif
#endif
#ifdef COLORED
    light *= color;
#endif
#ifdef LIT
    light = pow(light, vec3(1.0 / 2.2));
#endif
    picture = vec4(clamp(light, 0.0, 1.0), 1.0);
}
