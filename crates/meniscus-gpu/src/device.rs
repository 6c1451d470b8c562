//! Which adapter to use, and whether it is still there.

use crate::build::Builders;
use crate::error::GpuError;
use crate::program::Programs;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use wgpu::{AdapterInfo, Backends, DeviceType};

/// `off`: no adapter counts; `software`: drivers that run on the processor count too, where a card is
/// asked for.
const ADAPTERS_VARIABLE: &str = "MENISCUS_GPU";

/// Test hook: the device is removed after so many batches of rays.
const LOSE_VARIABLE: &str = "MENISCUS_GPU_LOSE_AFTER";

/// Which adapters count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum AdapterChoice {
    /// Cards only.
    #[default]
    Card,
    /// Cards, and drivers that run on the processor where there is none: for tests.
    CardOrSoftware,
    /// None.
    Nothing,
}

impl AdapterChoice {
    /// What the environment allows: cards, unless `MENISCUS_GPU` is `off` or `software`.
    pub fn from_environment() -> Self {
        match std::env::var(ADAPTERS_VARIABLE).as_deref() {
            Ok("off") => Self::Nothing,
            Ok("software") => Self::CardOrSoftware,
            _ => Self::Card,
        }
    }

    /// The same without software.
    #[must_use]
    pub fn without_software(self) -> Self {
        match self {
            Self::Card | Self::CardOrSoftware => Self::Card,
            Self::Nothing => Self::Nothing,
        }
    }
}

/// How to open a device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct OpenOptions {
    /// Which adapters count.
    pub choice: AdapterChoice,
    /// Test hook: after so many batches of rays the device is removed.
    pub lose_after: Option<u64>,
}

impl OpenOptions {
    /// What the environment says.
    pub fn from_environment() -> Self {
        Self {
            choice: AdapterChoice::from_environment(),
            lose_after: std::env::var(LOSE_VARIABLE)
                .ok()
                .and_then(|text| text.parse().ok()),
        }
    }
}

/// An open device.
#[derive(Debug)]
pub struct Device {
    pub(crate) device: wgpu::Device,
    pub(crate) queue: wgpu::Queue,
    pub(crate) limits: wgpu::Limits,
    pub(crate) has_timestamps: bool,
    pub(crate) programs: Programs,
    pub(crate) builders: Builders,
    pub(crate) peel: crate::peel::Kept,
    pub(crate) stages: crate::stages::StagePrograms,
    info: AdapterInfo,
    /// What went wrong first, if anything did.
    trouble: Arc<Mutex<Option<String>>>,
    batches: AtomicU64,
    lose_after: Option<u64>,
}

/// How much an adapter is worth; `None`: not one that may be used.
fn rank(info: &AdapterInfo, choice: AdapterChoice) -> Option<u32> {
    match (info.device_type, choice) {
        (_, AdapterChoice::Nothing) => None,
        (DeviceType::DiscreteGpu, _) => Some(4),
        (DeviceType::IntegratedGpu, _) => Some(3),
        (DeviceType::VirtualGpu, _) => Some(2),
        (DeviceType::Cpu, AdapterChoice::CardOrSoftware) => Some(1),
        // What the driver does not tell is not taken for a card.
        (DeviceType::Other | DeviceType::Cpu, _) => None,
    }
}

/// Whether this machine may have a card at all: asking drivers takes time.
fn may_have_card() -> bool {
    if !cfg!(target_os = "linux") {
        return true;
    }
    let nodes = [
        "/dev/dri",
        "/dev/nvidia0",
        "/dev/nvidiactl",
        "/dev/dxg",
        "/dev/kgsl-3d0",
        "/dev/mali0",
    ];
    nodes.iter().any(|node| std::path::Path::new(node).exists())
}

impl Device {
    /// Opens the best adapter that counts.
    ///
    /// # Errors
    /// Where there is none, or the driver refuses.
    pub fn open(options: OpenOptions) -> Result<Self, GpuError> {
        let is_hopeless = match options.choice {
            AdapterChoice::Card => !may_have_card(),
            AdapterChoice::CardOrSoftware => false,
            AdapterChoice::Nothing => true,
        };
        if is_hopeless {
            return Err(GpuError::NoAdapter {
                seen: String::new(),
            });
        }
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
            backends: Backends::VULKAN | Backends::METAL | Backends::DX12,
            ..wgpu::InstanceDescriptor::new_without_display_handle()
        });
        let adapters = pollster::block_on(instance.enumerate_adapters(Backends::all()));
        let infos: Vec<AdapterInfo> = adapters.iter().map(wgpu::Adapter::get_info).collect();
        let best = (0..adapters.len())
            .filter_map(|index| Some((rank(&infos[index], options.choice)?, index)))
            .max_by_key(|&(rank, index)| (rank, std::cmp::Reverse(index)));
        let Some((_, index)) = best else {
            let names: Vec<&str> = infos.iter().map(|info| info.name.as_str()).collect();
            let seen = match names.is_empty() {
                true => String::new(),
                false => format!(", only software: {}", names.join(", ")),
            };
            return Err(GpuError::NoAdapter { seen });
        };
        Self::of_adapter(&adapters[index], infos[index].clone(), options)
    }

    fn of_adapter(
        adapter: &wgpu::Adapter,
        info: AdapterInfo,
        options: OpenOptions,
    ) -> Result<Self, GpuError> {
        let limits = adapter.limits();
        let timestamps = wgpu::Features::TIMESTAMP_QUERY;
        let has_timestamps = adapter.features().contains(timestamps);
        let request = adapter.request_device(&wgpu::DeviceDescriptor {
            label: Some("meniscus"),
            required_features: if has_timestamps {
                timestamps
            } else {
                wgpu::Features::empty()
            },
            required_limits: limits.clone(),
            experimental_features: wgpu::ExperimentalFeatures::disabled(),
            memory_hints: wgpu::MemoryHints::MemoryUsage,
            trace: wgpu::Trace::Off,
        });
        let (device, queue) = pollster::block_on(request).map_err(|error| GpuError::Refused {
            adapter: info.name.clone(),
            message: error.to_string(),
        })?;
        let trouble = Arc::new(Mutex::new(None));
        let note = Arc::clone(&trouble);
        device.set_device_lost_callback(move |_, message| first_trouble(&note, &message));
        let note = Arc::clone(&trouble);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            first_trouble(&note, &error.to_string());
        }));
        Ok(Self {
            device,
            queue,
            limits,
            has_timestamps,
            programs: Programs::default(),
            builders: Builders::default(),
            peel: crate::peel::Kept::default(),
            stages: crate::stages::StagePrograms::default(),
            info,
            trouble,
            batches: AtomicU64::new(0),
            lose_after: options.lose_after,
        })
    }

    /// The adapter's name.
    pub fn name(&self) -> &str {
        &self.info.name
    }

    /// The adapter, its kind and driver, for messages.
    pub fn describe(&self) -> String {
        let kind = match self.info.device_type {
            DeviceType::DiscreteGpu => "discrete",
            DeviceType::IntegratedGpu => "integrated",
            DeviceType::VirtualGpu => "virtual",
            DeviceType::Cpu => "software",
            DeviceType::Other => "unknown kind",
        };
        let driver = format!("{} {}", self.info.driver, self.info.driver_info);
        format!("{} ({kind}, {})", self.info.name, driver.trim())
    }

    /// Whether shaders run on the processor after all.
    pub fn is_software(&self) -> bool {
        self.info.device_type == DeviceType::Cpu
    }

    /// Removes the device, as a driver's reset or a pulled card would: for tests.
    pub fn lose(&self) {
        self.device.destroy();
    }

    /// Largest storage buffer that a shader takes, in bytes.
    pub(crate) fn largest_binding(&self) -> u64 {
        let limits = &self.limits;
        limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size)
    }

    /// Counts a batch that is about to be sent.
    pub(crate) fn count_batch(&self) {
        let sent = self.batches.fetch_add(1, Ordering::Relaxed);
        if self.lose_after.is_some_and(|after| sent >= after) {
            self.lose();
        }
    }

    /// Whether the device is gone.
    pub fn is_lost(&self) -> bool {
        self.check().is_err()
    }

    /// What went wrong so far.
    pub(crate) fn check(&self) -> Result<(), GpuError> {
        let trouble = self.trouble.lock().unwrap_or_else(PoisonError::into_inner);
        match &*trouble {
            None => Ok(()),
            Some(message) => Err(self.lost(message.clone())),
        }
    }

    /// The error of a device that is gone.
    pub(crate) fn lost(&self, message: String) -> GpuError {
        GpuError::Lost {
            adapter: self.info.name.clone(),
            message,
        }
    }

    /// Waits until everything sent is done.
    pub(crate) fn wait(&self) -> Result<(), GpuError> {
        self.device
            .poll(wgpu::PollType::wait_indefinitely())
            .map_err(|error| self.lost(error.to_string()))?;
        self.check()
    }

    /// Runs `make` and turns what the driver says about memory into an error.
    pub(crate) fn within_memory<T>(
        &self,
        bytes: u64,
        make: impl FnOnce() -> T,
    ) -> Result<T, GpuError> {
        let scope = self.device.push_error_scope(wgpu::ErrorFilter::OutOfMemory);
        let made = make();
        match pollster::block_on(scope.pop()) {
            None => Ok(made),
            Some(error) => Err(self.too_large(bytes, error.to_string())),
        }
    }

    pub(crate) fn too_large(&self, bytes: u64, message: String) -> GpuError {
        GpuError::TooLarge {
            adapter: self.info.name.clone(),
            bytes,
            message,
        }
    }
}

/// Keeps the first message.
fn first_trouble(trouble: &Mutex<Option<String>>, message: &str) {
    let mut trouble = trouble.lock().unwrap_or_else(PoisonError::into_inner);
    if trouble.is_none() {
        let message = match message.trim() {
            "" => "the driver gives no reason",
            said => said,
        };
        *trouble = Some(message.to_owned());
    }
}
