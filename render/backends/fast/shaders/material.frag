// A material of glTF 2.0 under ambient light, a sun that throws shadows and LAMPS lamps that do not.
// GGX facets hidden by Smith's term (Heitz 2014), Fresnel by Schlick; light that facets throw at
// each other is made up for (Fdez-Aguera 2019). Colours are linear, premultiplied by alpha; the
// framebuffer encodes them. What is defined: LIT, COLORED, FLAT, TWO_SIDED, MASKED, BLENDED, and for
// each map its name: BASE_MAP, ROUGH_MAP, NORMAL_MAP, OCCLUSION_MAP, EMISSION_MAP, whose value is
// first_set or second_set.

out vec4 picture;
in vec3 world_position;
in vec3 normal;
in vec3 place_in_light;
#ifdef COLORED
in vec4 color;
#endif
#ifdef FIRST_SET
in vec2 first_set;
#endif
#ifdef SECOND_SET
in vec2 second_set;
#endif

uniform vec4 base_color;
uniform vec3 emission;
uniform float metallic;
uniform float roughness;
uniform float normal_scale;
uniform float occlusion_strength;
uniform float alpha_cutoff;
#ifdef BASE_MAP
uniform sampler2D base_map;
uniform mat3x2 base_map_place;
#endif
#ifdef ROUGH_MAP
uniform sampler2D metallic_roughness_map;
uniform mat3x2 metallic_roughness_map_place;
#endif
#ifdef NORMAL_MAP
uniform sampler2D normal_map;
uniform mat3x2 normal_map_place;
#endif
#ifdef OCCLUSION_MAP
uniform sampler2D occlusion_map;
uniform mat3x2 occlusion_map_place;
#endif
#ifdef EMISSION_MAP
uniform sampler2D emission_map;
uniform mat3x2 emission_map_place;
#endif

#ifdef LIT
uniform vec3 eye;
uniform vec3 ambient;
uniform vec3 to_sun;
uniform vec3 sun;
uniform sampler2DShadow shadow_map;
uniform sampler2D mirrored_table;
#if LAMPS > 0
uniform vec3 lamp_position[LAMPS];
uniform vec3 lamp[LAMPS];
#endif

const float PI = 3.141592653589793;
// Mirrors of a dielectric at normal incidence, and the smoothest surface that is drawn: smoother
// ones would show a highlight smaller than a pixel.
const float MIRRORED = 0.04;
const float SMOOTHEST = 0.0525;

struct Facets {
    vec3 diffuse;
    vec3 mirrored;
    float rough;
};

// Scale and offset of the mirrored colour under even light.
vec2 even(float rough, float nv)
{
    return texture(mirrored_table, vec2(rough, nv)).rg;
}

vec3 reflected(vec3 n, vec3 v, vec3 l, Facets facets)
{
    vec3 h = normalize(l + v);
    float nl = clamp(dot(n, l), 0.0, 1.0);
    float nv = clamp(dot(n, v), 0.0, 1.0);
    float nh = clamp(dot(n, h), 0.0, 1.0);
    float away = 1.0 - clamp(dot(v, h), 0.0, 1.0);
    float away2 = away * away;
    vec3 fresnel = facets.mirrored + (1.0 - facets.mirrored) * (away2 * away2 * away);
    float a = facets.rough * facets.rough;
    float a2 = a * a;
    float seen = nl * sqrt(a2 + (1.0 - a2) * nv * nv) + nv * sqrt(a2 + (1.0 - a2) * nl * nl);
    float spread = nh * nh * (a2 - 1.0) + 1.0;
    vec3 once = fresnel * (0.5 / max(seen, 1e-6)) * (a2 / (PI * spread * spread));
    vec2 from_eye = even(facets.rough, nv);
    vec2 from_light = even(facets.rough, nl);
    float lost = (1.0 - from_eye.x - from_eye.y) * (1.0 - from_light.x - from_light.y);
    vec3 mean = facets.mirrored + (1.0 - facets.mirrored) / 21.0;
    vec3 again = (facets.mirrored * from_eye.x + from_eye.y)
        * (facets.mirrored * from_light.x + from_light.y) * mean / (1.0 - lost * mean + 1e-6);
    return nl * ((1.0 - fresnel) * facets.diffuse / PI + once + again * lost);
}

// Share of even light that facets mirror, thrown at each other or not.
vec3 mirrored_evenly(Facets facets, float nv)
{
    vec2 both = even(facets.rough, nv);
    vec3 once = facets.mirrored * both.x + both.y;
    float lost = 1.0 - both.x - both.y;
    vec3 mean = facets.mirrored + (1.0 - facets.mirrored) / 21.0;
    return once + once * mean * lost / (1.0 - lost * mean);
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

#ifdef NORMAL_MAP
// The map's normal in the world. Tangents come from how place and coordinates change between pixels
// (Mikkelsen 2013, "Followup: Normal Mapping Without Precomputed Tangents").
vec3 bent(vec3 n, vec2 place, float side)
{
    vec3 q0 = dFdx(world_position);
    vec3 q1 = dFdy(world_position);
    vec2 st0 = dFdx(place);
    vec2 st1 = dFdy(place);
    vec3 along = cross(q1, n);
    vec3 across = cross(n, q0);
    vec3 t = along * st0.x + across * st1.x;
    vec3 b = along * st0.y + across * st1.y;
    float size = max(dot(t, t), dot(b, b));
    float scale = size == 0.0 ? 0.0 : side * inversesqrt(size);
    vec3 own = texture(normal_map, place).xyz * 2.0 - 1.0;
    own.xy *= normal_scale * vec2(1.0, -1.0);
    return normalize(t * scale * own.x + b * scale * own.y + n * own.z);
}
#endif

vec3 lit(vec3 base)
{
    float metal = metallic;
    float rough = roughness;
#ifdef ROUGH_MAP
    vec4 given = texture(metallic_roughness_map,
                         metallic_roughness_map_place * vec3(ROUGH_MAP, 1.0));
    rough *= given.g;
    metal *= given.b;
#endif
    float side = 1.0;
#ifdef TWO_SIDED
    side = gl_FrontFacing ? 1.0 : -1.0;
#endif
#ifdef FLAT
    vec3 n = normalize(cross(dFdx(world_position), dFdy(world_position)));
#else
    vec3 n = side * normalize(normal);
#endif
    vec3 change = max(abs(dFdx(n)), abs(dFdy(n)));
    rough = min(max(rough, SMOOTHEST) + max(max(change.x, change.y), change.z), 1.0);
#ifdef NORMAL_MAP
    n = bent(n, normal_map_place * vec3(NORMAL_MAP, 1.0), side);
#endif
    Facets facets = Facets(base * (1.0 - metal), mix(vec3(MIRRORED), base, metal), rough);
    vec3 v = normalize(eye - world_position);
    float open = 1.0;
#ifdef OCCLUSION_MAP
    open = 1.0 + occlusion_strength
        * (texture(occlusion_map, occlusion_map_place * vec3(OCCLUSION_MAP, 1.0)).r - 1.0);
#endif
    vec3 light = open * ambient * facets.diffuse
        * (1.0 - mirrored_evenly(facets, clamp(dot(n, v), 0.0, 1.0)));
    float nl = dot(n, to_sun);
    if (nl > 0.0) {
        light += sun * reflected(n, v, to_sun, facets) * sunlit(nl);
    }
#if LAMPS > 0
    for (int i = 0; i < LAMPS; ++i) {
        vec3 way = lamp_position[i] - world_position;
        float square = dot(way, way);
        light += lamp[i] / square * reflected(n, v, way * inversesqrt(square), facets);
    }
#endif
    vec3 own = emission;
#ifdef EMISSION_MAP
    own *= texture(emission_map, emission_map_place * vec3(EMISSION_MAP, 1.0)).rgb;
#endif
    return light + own;
}
#endif

#ifdef BASE_MAP
// As four samples a pixel would read it: sharper at a slant than mipmaps alone, and drivers that
// draw on the processor take a tenth of the time that their anisotropic filter takes.
vec4 read_base(vec2 place)
{
    vec2 across = 0.25 * dFdx(place);
    vec2 down = 0.25 * dFdy(place);
    return 0.25 * (texture(base_map, place - across - down, -1.0)
        + texture(base_map, place + across - down, -1.0)
        + texture(base_map, place - across + down, -1.0)
        + texture(base_map, place + across + down, -1.0));
}
#endif

void main()
{
    vec4 base = base_color;
#ifdef BASE_MAP
    base *= read_base(base_map_place * vec3(BASE_MAP, 1.0));
#endif
#ifdef COLORED
    base *= color;
#endif
#ifdef LIT
    vec3 light = lit(base.rgb);
#else
    vec3 light = base.rgb;
#endif
    float alpha = 1.0;
#ifdef MASKED
    // The share of the pixel that lies above the cutoff, for a multisampled edge.
    alpha = clamp((base.a - alpha_cutoff) / max(fwidth(base.a), 1e-4) + 0.5, 0.0, 1.0);
    if (alpha <= 0.0) {
        discard;
    }
#endif
#ifdef BLENDED
    alpha = base.a;
    light *= alpha;
#endif
    picture = vec4(clamp(light, 0.0, 1.0), alpha);
}
