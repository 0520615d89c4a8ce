#include "tools/clouds/grow_l_system.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string_view>
#include <utility>

namespace nephele::clouds {
namespace {

constexpr std::string_view kSigns = "+-&^\\/!\"[]";
constexpr std::size_t kMaxRules = 256, kMaxText = 10000;

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); }

bool are_symbols(const std::string& text) {
  return text.size() <= kMaxText && std::all_of(text.begin(), text.end(), [](char c) {
           return is_letter(c) || kSigns.find(c) != std::string_view::npos;
         });
}

// Every ] closes a [ of its own text.
bool are_balanced(const std::string& text) {
  int open = 0;
  for (const char c : text) {
    open += c == '[' ? 1 : c == ']' ? -1 : 0;
    if (open < 0) return false;
  }
  return open == 0;
}

void read_symbols(JsonObject& json, const char* key, std::string& text) {
  json.string(key, text);
  if (!json.has(key)) return;
  if (!are_symbols(text)) json.refuse(key, "at most 10000 letters and + - & ^ \\ / ! \" [ ]");
  if (!are_balanced(text)) json.refuse(key, "a ] for every [ and none before it");
}

struct Turtle {
  glm::dvec3 place_m{0.0};
  glm::dvec3 ahead{0.0, 1.0, 0.0}, left{-1.0, 0.0, 0.0}, up{0.0, 0.0, 1.0};
  double step_m = 0.0, radius_m = 0.0;
};

// Turns two directions at right angles from the first towards the second.
void turn(glm::dvec3& from, glm::dvec3& towards, double angle_rad) {
  const SineCosine by = sine_cosine(angle_rad);
  const glm::dvec3 turned = from * by.cosine + towards * by.sine;
  towards = glm::normalize(towards * by.cosine - from * by.sine);
  from = glm::normalize(turned);
}

// Turns the turtle towards the zenith by a share of the way.
void rise(Turtle& turtle, double share) {
  if (share <= 0.0) return;
  const glm::dvec3 ahead = turtle.ahead * (1.0 - share) + glm::dvec3(0.0, 0.0, share);
  if (glm::dot(ahead, ahead) < 1e-6) return;
  turtle.ahead = glm::normalize(ahead);
  glm::dvec3 left = turtle.left - turtle.ahead * glm::dot(turtle.left, turtle.ahead);
  if (glm::dot(left, left) < 1e-6) left = glm::cross(turtle.up, turtle.ahead);
  turtle.left = glm::normalize(left);
  turtle.up = glm::cross(turtle.ahead, turtle.left);
}

}  // namespace

LSystemParameters::LSystemParameters() {
  // R creeps along the base and forks; S is a shoot that turns upwards; T grows, forks and thins out; B is a body that
  // no rule changes.
  axiom = "S[R]++[R]++[R]++[R]++[R]++[fS]+[R]";
  rules = {{"R", "SB[+R]-R", 1.0}, {"R", "BSR", 2.0},          {"R", "B+S!R", 1.0},      {"R", "S", 0.8},
           {"S", "[^^^FT]", 1.0},  {"T", "FT", 1.5},           {"T", "F[&!\"T]/T", 2.0}, {"T", "F!\"[&T]//[^T]", 1.5},
           {"T", "F!\"T", 1.0},    {"T", "F[-!\"T]+!\"T", 2.0}};
  bodies = "FB";
}

void read_l_system(JsonObject& json, LSystemParameters& p) {
  json.integer("seed", p.seed);
  read_symbols(json, "axiom", p.axiom);
  std::vector<GrammarRule> rules;
  json.objects("rules", kMaxRules, [&](JsonObject& rule) {
    GrammarRule& read = rules.emplace_back();
    rule.require("symbol");
    rule.require("becomes");
    rule.string("symbol", read.symbol);
    if (rule.has("symbol") && !(read.symbol.size() == 1 && is_letter(read.symbol[0])))
      rule.refuse("symbol", "one letter");
    read_symbols(rule, "becomes", read.becomes);
    rule.number("weight", read.weight, {1e-6, 1e6});
  });
  if (json.has("rules")) p.rules = std::move(rules);
  json.string("bodies", p.bodies);
  if (json.has("bodies") && !std::all_of(p.bodies.begin(), p.bodies.end(), is_letter)) json.refuse("bodies", "letters");
  json.integer("generations", p.generations, 0, 30);
  json.number("start_pitch_deg", p.start_pitch_deg, {-90.0, 90.0});
  json.number("angle_deg", p.angle_deg, {-180.0, 180.0});
  json.number("angle_spread_deg", p.angle_spread_deg, {0.0, 180.0});
  json.number("step_m", p.step_m, {0.0, 5000.0});
  json.number("step_spread", p.step_spread, {0.0, 0.95});
  json.number("step_shrink", p.step_shrink, {0.1, 1.0});
  json.number("radius_m", p.radius_m, {1.0, 5000.0});
  json.number("radius_spread", p.radius_spread, {0.0, 0.95});
  json.number("radius_shrink", p.radius_shrink, {0.1, 1.0});
  json.number("rise", p.rise, {0.0, 1.0});
  json.boolean("flat_base", p.flat_base);
  json.number("extinction_per_m", p.extinction_per_m, {1e-4, 10.0});
  json.object("skin", [&](JsonObject& skin) { read_skin(skin, p.skin); });
}

Result<std::string> expand_grammar(const LSystemParameters& parameters, RandomSequence& random) {
  std::string text = parameters.axiom;
  for (std::uint32_t generation = 0; generation < parameters.generations; ++generation) {
    std::string next;
    for (const char symbol : text) {
      double total = 0.0;
      for (const GrammarRule& rule : parameters.rules)
        if (rule.symbol[0] == symbol) total += rule.weight;
      if (total <= 0.0) {
        next += symbol;
      } else {
        double left = random.unit() * total;
        const GrammarRule* chosen = nullptr;
        for (const GrammarRule& rule : parameters.rules) {
          if (rule.symbol[0] != symbol) continue;
          chosen = &rule;
          if ((left -= rule.weight) < 0.0) break;
        }
        next += chosen->becomes;
      }
      if (next.size() > kMaxSymbols)
        return Error{"generations is " + std::to_string(parameters.generations) + "; after " +
                     std::to_string(generation + 1) + " the text is longer than " + std::to_string(kMaxSymbols) +
                     " symbols"};
    }
    text = std::move(next);
  }
  return text;
}

Result<std::vector<CloudBody>> turtle_bodies(const LSystemParameters& p) {
  RandomSequence choices(p.seed, 11), chances(p.seed, 12);
  const Result<std::string> text = expand_grammar(p, choices);
  if (!text) return text.error();
  Turtle turtle;
  turtle.step_m = p.step_m;
  turtle.radius_m = p.radius_m;
  turn(turtle.ahead, turtle.up, p.start_pitch_deg * kRadiansPerDegree);
  std::vector<Turtle> remembered;
  std::vector<CloudBody> bodies;
  const auto angle = [&] {
    return (p.angle_deg + p.angle_spread_deg * chances.between(-1.0, 1.0)) * kRadiansPerDegree;
  };
  const auto spread = [&](double share) { return 1.0 + share * chances.between(-1.0, 1.0); };
  for (const char symbol : *text) {
    const bool leaves_body = p.bodies.find(symbol) != std::string::npos;
    if (leaves_body || symbol == 'f') {
      rise(turtle, p.rise);
      turtle.place_m += turtle.ahead * (turtle.step_m * spread(p.step_spread));
      if (!leaves_body) continue;
      if (bodies.size() == kMaxGrownBodies)
        return Error{"generations is " + std::to_string(p.generations) + "; it leaves more than " +
                     std::to_string(kMaxGrownBodies) + " bodies"};
      const double radius = turtle.radius_m * spread(p.radius_spread);
      bodies.push_back({turtle.place_m, {radius, radius, 0.9 * radius}, p.extinction_per_m});
      continue;
    }
    switch (symbol) {
      case '+':
        turn(turtle.ahead, turtle.left, angle());
        break;
      case '-':
        turn(turtle.ahead, turtle.left, -angle());
        break;
      case '&':
        turn(turtle.ahead, turtle.up, -angle());
        break;
      case '^':
        turn(turtle.ahead, turtle.up, angle());
        break;
      case '\\':
        turn(turtle.left, turtle.up, -angle());
        break;
      case '/':
        turn(turtle.left, turtle.up, angle());
        break;
      case '!':
        turtle.radius_m *= p.radius_shrink;
        break;
      case '"':
        turtle.step_m *= p.step_shrink;
        break;
      case '[':
        remembered.push_back(turtle);
        break;
      case ']':
        turtle = remembered.back();
        remembered.pop_back();
        break;
      default:
        break;
    }
  }
  return bodies;
}

Result<ParticleSet> grow_l_system(const LSystemParameters& p) {
  Result<std::vector<CloudBody>> bodies = turtle_bodies(p);
  if (!bodies) return bodies.error();
  if (bodies->empty()) return Error{"the grammar leaves no body; \"bodies\" names the letters that do"};
  if (p.flat_base)  // what has crept below the base is no cloud
    bodies->erase(std::remove_if(bodies->begin(), bodies->end(),
                                 [](const CloudBody& body) { return body.center_m.z < -0.6 * body.radius_m.z; }),
                  bodies->end());
  if (bodies->empty()) return Error{"the grammar leaves no body above the base"};
  keep_connected(*bodies);
  RandomSequence skin(p.seed, 13);
  grow_skin(*bodies, p.skin, p.flat_base ? 0.25 * p.skin.smallest_m : -1e9, skin);
  Result<ParticleSet> set = set_of_bodies(std::move(*bodies), p.flat_base);
  if (!set) return set;
  set->source = "grow l_system";
  auto parameters =
      nlohmann::ordered_json::parse(parameters_text([q = p](JsonObject& json) mutable { read_l_system(json, q); }));
  for (const GrammarRule& rule : p.rules)
    parameters["rules"].push_back({{"symbol", rule.symbol}, {"becomes", rule.becomes}, {"weight", rule.weight}});
  set->parameters = parameters.dump();
  return set;
}

}  // namespace nephele::clouds
