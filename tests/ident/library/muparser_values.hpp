#pragma once
#include <cmath>
#include <limits>
#include <vector>

namespace recorded {

/// What muParser 2.3.3 gave for texts at (x, v, ddr, z) = (0.7, -0.31, 0.0113, -2.3), (-1.3, 2.1, 0.5, 0.77) and
/// (0.013, -0.0027, -9.81, 1.9), before the tree took its place.
struct Value {
  const char* text;
  double at[3];
};
constexpr double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();

inline const std::vector<Value> exact{
    {"1", {0x1p+0, 0x1p+0, 0x1p+0}},
    {"x", {0x1.6666666666666p-1, -0x1.4cccccccccccdp+0, 0x1.a9fbe76c8b439p-7}},
    {"v", {-0x1.3d70a3d70a3d7p-2, 0x1.0cccccccccccdp+1, -0x1.61e4f765fd8aep-9}},
    {"x^2", {0x1.f5c28f5c28f5bp-2, 0x1.b0a3d70a3d70bp+0, 0x1.626b2f23033a4p-13}},
    {"x*v", {-0x1.bc6a7ef9db22dp-3, -0x1.5d70a3d70a3d8p+1, -0x1.2670ad1145a2ap-15}},
    {"v^2", {0x1.89a027525460bp-4, 0x1.1a3d70a3d70a4p+2, 0x1.e9393f10e1fa9p-18}},
    {"x^3", {0x1.5f3b645a1cabfp-2, -0x1.19374bc6a7efbp+1, 0x1.26e0585eaa9f1p-19}},
    {"x^2*v", {-0x1.371758e219652p-3, 0x1.c645a1cac0832p+1, -0x1.e9f2c9f7e06acp-22}},
    {"x*v^2", {0x1.1389b52007dd4p-4, -0x1.6ee978d4fdf3cp+2, 0x1.9708b78af9745p-24}},
    {"v^3", {-0x1.e81882adc4c9dp-6, 0x1.285a1cac08313p+3, -0x1.5226bfddcb4cfp-26}},
    {"x^4", {0x1.ebb98c7e2823ep-3, 0x1.6d94af4f0d847p+1, 0x1.eaac9b3d44dfbp-26}},
    {"x^3*v", {-0x1.b387160956c0cp-4, -0x1.2746dc5d63888p+2, -0x1.97a316a12d673p-28}},
    {"x^2*v^2", {0x1.81c0ca600b029p-5, 0x1.dcfc504816f02p+2, 0x1.52a6ff1b900edp-30}},
    {"x*v^3", {-0x1.55aac1e009c07p-6, -0x1.8141f212d7733p+3, -0x1.1957891ad633bp-32}},
    {"v^4", {0x1.2e9e8e75fa024p-7, 0x1.372b6ae7d566ep+4, 0x1.d375dfddd22e9p-35}},
    {"x^5", {0x1.5835158b827f8p-3, -0x1.db414a4d2b2c1p+1, 0x1.983db0435c1e7p-32}},
    {"x^4*v", {-0x1.30de8f6cefed4p-4, 0x1.7fdc1e7967cb1p+2, -0x1.53276efce230fp-34}},
    {"x^3*v^2", {0x1.0e06f41007b4fp-5, -0x1.360a67620ee8fp+3, 0x1.19c23cb294873p-36}},
    {"x^2*v^3", {-0x1.de5575d340da3p-7, 0x1.f4d5bab21815cp+3, -0x1.d42729c6419dbp-39}},
    {"x*v^4", {0x1.a7aac771f79ccp-8, -0x1.94853e2d6238fp+4, 0x1.84ed55e7a8ba3p-41}},
    {"v^5", {-0x1.773f7d73922bbp-9, 0x1.46ba63736cdf4p+5, -0x1.431bd1369bed7p-43}},
    {"ddr", {0x1.72474538ef34dp-7, 0x1p-1, -0x1.39eb851eb851fp+3}},
    {"sgn(v)", {-0x1p+0, 0x1p+0, -0x1p+0}},
    {"sgn(v)*v^2", {-0x1.89a027525460bp-4, 0x1.1a3d70a3d70a4p+2, -0x1.e9393f10e1fa9p-18}},
    {"abs(x)*v", {-0x1.bc6a7ef9db22dp-3, 0x1.5d70a3d70a3d8p+1, -0x1.2670ad1145a2ap-15}},
    {"abs(v)*v", {-0x1.89a027525460bp-4, 0x1.1a3d70a3d70a4p+2, -0x1.e9393f10e1fa9p-18}},
    {"abs(v)^2", {0x1.89a027525460bp-4, 0x1.1a3d70a3d70a4p+2, 0x1.e9393f10e1fa9p-18}},
    {"z*abs(z)^0.5*abs(v)", {-0x1.14d1424b2ab31p+0, 0x1.6b3dccc5669c1p+0, 0x1.cf6b55ccd3b8cp-8}},
    {"abs(z)^1.5*v", {-0x1.14d1424b2ab31p+0, 0x1.6b3dccc5669cp+0, -0x1.cf6b55ccd3b8dp-8}},
    {"v*sin(x)", {-0x1.99003ca38345fp-3, -0x1.030122fede31bp+1, -0x1.266e8d8e5473p-15}},
    {"x/v^2", {0x1.d22e5a0a1f6fp+2, -0x1.2ddc02526e4b7p-2, 0x1.bdd0f19a296ffp+10}},
    {"exp(x)*tanh(v)", {-0x1.35c35948b78d5p-1, 0x1.0ed395aacfb55p-2, -0x1.6686315207a09p-9}},
    {"cos(1e5*x)", {0x1.227c3863b3ce7p-1, 0x1.3fde43ecb9017p-1, 0x1.a0e580e948447p-1}},
    {"log(x)", {-0x1.6d3c324e13f5p-2, nan, -0x1.15f0883f73978p+2}},
    {"sqrt(abs(x))", {0x1.ac5eb3f7ab2f8p-1, 0x1.23e2896280f23p+0, 0x1.d3040f0401837p-4}},
    {"sqrt(-1-x^2)", {nan, nan, nan}},
    {"sgn(x-0.1)*v", {-0x1.3d70a3d70a3d7p-2, -0x1.0cccccccccccdp+1, 0x1.61e4f765fd8aep-9}},
    {"x-0.1", {0x1.3333333333333p-1, -0x1.6666666666667p+0, -0x1.645a1cac08313p-4}},
    {"1-x", {0x1.3333333333334p-2, 0x1.2666666666666p+1, 0x1.f95810624dd2fp-1}},
    {"x*x", {0x1.f5c28f5c28f5bp-2, 0x1.b0a3d70a3d70bp+0, 0x1.626b2f23033a4p-13}},
    {"-x^2", {-0x1.f5c28f5c28f5bp-2, -0x1.b0a3d70a3d70bp+0, -0x1.626b2f23033a4p-13}},
    {"-2^2*x^3", {-0x1.5f3b645a1cabfp+0, 0x1.19374bc6a7efbp+3, -0x1.26e0585eaa9f1p-17}},
    {"2^3^2", {0x1p+9, 0x1p+9, 0x1p+9}},
    {"2^-x", {0x1.3b2c47bff8329p-1, 0x1.3b2c47bff8329p+1, 0x1.fb683a172d408p-1}},
    {"2^-x*3", {0x1.d8c26b9ff44bep+0, 0x1.d8c26b9ff44bep+2, 0x1.7c8e2b9161f06p+1}},
    {"2^-x^2", {0x1.6c8e8db9f3aafp-1, 0x1.3d5d7bdbd65b2p-2, 0x1.fff0a599e7179p-1}},
    {"-x^-2", {-0x1.05397829cbc15p+1, -0x1.2ef5657dba51cp-1, -0x1.71d28e63f9f0ep+12}},
    {"x^+v", {0x1.1dee0df30179fp+0, nan, 0x1.0304f86276ca5p+0}},
    {"x- -v", {0x1.8f5c28f5c28f5p-2, 0x1.999999999999ap-1, 0x1.5182a9930be0ep-7}},
    {"x*-v", {0x1.bc6a7ef9db22dp-3, 0x1.5d70a3d70a3d8p+1, 0x1.2670ad1145a2ap-15}},
    {"-x*v", {0x1.bc6a7ef9db22dp-3, 0x1.5d70a3d70a3d8p+1, 0x1.2670ad1145a2ap-15}},
    {"x^0", {0x1p+0, 0x1p+0, 0x1p+0}},
    {"x^1", {0x1.6666666666666p-1, -0x1.4cccccccccccdp+0, 0x1.a9fbe76c8b439p-7}},
    {"(x-1)^2", {0x1.70a3d70a3d70cp-4, 0x1.528f5c28f5c28p+2, 0x1.f2c647778dd61p-1}},
    {"(x+v)^3", {0x1.e5f0f5a1016ccp-5, 0x1.0624dd2f1a9fdp-1, 0x1.2553a0ae0486bp-20}},
    {"(-8)^(1/3)", {nan, nan, nan}},
    {"x/7", {0x1.9999999999999p-4, -0x1.7c57c57c57c58p-3, 0x1.e6d6bf577a966p-10}},
    {"x<v<ddr", {0x1p+0, 0x0p+0, 0x0p+0}},
    {"x==v<ddr", {0x1p+0, 0x1p+0, 0x0p+0}},
    {"x<v==ddr", {0x0p+0, 0x0p+0, 0x0p+0}},
    {"x+v<ddr", {0x0p+0, 0x0p+0, 0x0p+0}},
    {"1||0&&0", {0x1p+0, 0x1p+0, 0x1p+0}},
    {"x<v&&v<ddr", {0x0p+0, 0x0p+0, 0x0p+0}},
    {"x!=v", {0x1p+0, 0x1p+0, 0x1p+0}},
    {"x<-v", {0x0p+0, 0x0p+0, 0x0p+0}},
    {"x>=v||z<=1", {0x1p+0, 0x1p+0, 0x1p+0}},
    {"1/(x-x)", {inf, inf, inf}},
    {"x-v-ddr", {0x1.ff559b3d07c85p-1, -0x1.f333333333334p+1, 0x1.3a6c226809d4ap+3}},
    {"x/v/ddr", {-0x1.8fa84dc1e1beap+7, -0x1.3cf3cf3cf3cf4p+0, 0x1.f6960f85ada22p-2}},
    {"x/(v/ddr)", {-0x1.a20e66edb33b9p-6, -0x1.3cf3cf3cf3cf4p-2, 0x1.79dddddddddddp+5}},
};
/// muParser folded numbers into linear terms (3 (x + 0.1) into 3 x + 0.3): the same but for rounding.
inline const std::vector<Value> folded{
    {"3*(x+0.1)", {0x1.3333333333332p+1, -0x1.ccccccccccccep+1, 0x1.5b22d0e560419p-2}},
    {"3*x/7", {0x1.3333333333333p-2, -0x1.1d41d41d41d42p-1, 0x1.6d210f819bf0cp-8}},
    {"2*x+3*x", {0x1.cp+1, -0x1.ap+2, 0x1.0a3d70a3d70a4p-4}},
    {"0.3*x-v/3+0.7*(1-x)", {0x1.0bf258bf258cp-1, 0x1.0a3d70a3d70a2p-1, 0x1.6432ca57a786cp-1}},
};

}  // namespace recorded
