//! A perfect gas whose viscosity follows Sutherland's law.

/// Fields of a point: density [kg/m^3], momentum along each axis [kg/(m^2 s)], and energy of motion
/// and heat [J/m^3].
pub const MOST_FIELDS: usize = 5;

/// Number of fields in so many dimensions.
pub fn field_count(dims: usize) -> usize {
    dims + 2
}

/// A perfect gas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gas {
    /// Ratio of specific heats.
    pub heat_ratio: f64,
    /// Gas constant [J/(kg K)]: `p = rho R T`.
    pub gas_constant: f64,
    /// Viscosity at the reference temperature [Pa s]; 0 for none, and no conduction of heat.
    pub viscosity: f64,
    /// Reference temperature [K].
    pub reference: f64,
    /// Sutherland's temperature [K].
    pub sutherland: f64,
    /// Prandtl's number.
    pub prandtl: f64,
}

/// Density, velocity and pressure of a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GasState {
    /// Density [kg/m^3].
    pub density: f64,
    /// Velocity [m/s].
    pub velocity: [f64; 3],
    /// Pressure [Pa].
    pub pressure: f64,
}

impl Gas {
    /// A gas in the units of Goetsch (2015), sec. 2.2: density, temperature and speed of sound of
    /// the gas at rest are 1, its pressure `1/heat_ratio`. `reynolds` is the acoustic Reynolds
    /// number, if there is viscosity.
    pub fn scaled(reynolds: Option<f64>) -> Self {
        Self {
            heat_ratio: 1.4,
            gas_constant: 1.0 / 1.4,
            viscosity: reynolds.map_or(0.0, |reynolds| 1.0 / reynolds),
            reference: 1.0,
            sutherland: 0.368,
            prandtl: 0.72,
        }
    }

    /// Viscosity at a temperature [Pa s].
    #[inline(always)]
    pub fn viscosity_at(&self, temperature: f64) -> f64 {
        let relative = temperature / self.reference;
        let sum = (self.reference + self.sutherland) / (temperature + self.sutherland);
        self.viscosity * relative * relative.sqrt() * sum
    }

    /// Conductivity over viscosity [J/(kg K)]: specific heat over Prandtl's number.
    pub fn conduction(&self) -> f64 {
        self.heat_ratio * self.gas_constant / ((self.heat_ratio - 1.0) * self.prandtl)
    }

    /// Speed of sound [m/s].
    #[inline(always)]
    pub fn sound_speed(&self, density: f64, pressure: f64) -> f64 {
        (self.heat_ratio * pressure / density).sqrt()
    }

    /// Fields of a state, of which the first `dims + 2` are meaningful.
    pub fn fields(&self, dims: usize, state: GasState) -> [f64; MOST_FIELDS] {
        let mut fields = [0.0; MOST_FIELDS];
        fields[0] = state.density;
        let mut square = 0.0;
        for a in 0..dims {
            fields[1 + a] = state.density * state.velocity[a];
            square += state.velocity[a] * state.velocity[a];
        }
        fields[1 + dims] = state.pressure / (self.heat_ratio - 1.0) + 0.5 * state.density * square;
        fields
    }

    /// The state of fields.
    pub fn state(&self, dims: usize, fields: &[f64]) -> GasState {
        let density = fields[0];
        let velocity = [0, 1, 2].map(|a| if a < dims { fields[1 + a] / density } else { 0.0 });
        let square: f64 = velocity.iter().map(|u| u * u).sum();
        let pressure = (self.heat_ratio - 1.0) * (fields[1 + dims] - 0.5 * density * square);
        GasState { density, velocity, pressure }
    }
}
